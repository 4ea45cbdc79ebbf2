"""Many step flights at once: the law that flies around a rigid body, all of it compiled."""
