"""The app: fly, watch and tune. The only room that imports Qt; it imports no Drake."""
