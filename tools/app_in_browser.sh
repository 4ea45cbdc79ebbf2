#!/bin/sh
# Show the app in a browser, from a machine without a screen: an X server with VNC, a window manager,
# and noVNC at http://localhost:6080/vnc.html?autoconnect=true. Arguments are those of `workbench gui`.
# Needs Debian's tigervnc-standalone-server, novnc and openbox; the Dockerfile installs them.
# VNC has no password here: publish the port on this machine alone.
set -eu
export DISPLAY="${DISPLAY:-:1}"
number="${DISPLAY#:}"
trap 'kill $(jobs -p) 2>/dev/null' EXIT
trap 'exit 143' INT TERM
Xtigervnc "$DISPLAY" -localhost -SecurityTypes None -geometry "${GEOMETRY:-1600x1000}" -depth 24 &
until [ -S "/tmp/.X11-unix/X$number" ]; do
  kill -0 $! || exit 2 # it has said why it ended
  sleep 0.1
done
openbox &
websockify --web "${NOVNC:-/usr/share/novnc}" "${PORT:-6080}" "localhost:$((5900 + number))" &
workbench gui "$@" &
wait $!
