"""Image work: comparison, unwrapping, ground line, keypoints, landmarks, masks, scale planes."""
