"""The tuning screen: excite the drone, see its response, margins and poles, and choose gains."""
