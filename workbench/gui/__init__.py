"""The app: fly it, watch it, tune it. The only room that imports Qt; it imports no Drake."""
