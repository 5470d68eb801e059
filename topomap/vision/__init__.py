"""What panoramas tell: image work, compasses (`Aligner`), homing methods (`HomingMethod`), all by name."""
