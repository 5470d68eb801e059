"""What the robot senses with, and what spoils it: camera, range scanner, odometer."""
