"""The tuning screen: excite the drone, see its response, its margins and its poles, and choose."""
