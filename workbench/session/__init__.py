"""A flight that the caller steps: Session, its context, checkpoint, recording, snapshot."""
