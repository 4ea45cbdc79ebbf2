"""A flight that the caller advances: Session, its Context, checkpoint, recording and snapshot."""
