#!/bin/bash
# Runs LinuxCNC for caltwin, as the first process of namespaces of its own (unshare): its
# processes, shared memory, ports and /tmp are nobody else's, and all of it is gone when
# this script ends, which it does when LinuxCNC or caltwin does, however that ends.
#
#   start.sh FOLDER INI      FOLDER becomes /tmp, INI is in its config; descriptor 3: open as
#                            long as caltwin lives
set -euo pipefail
folder=$1 ini=$2
mount --bind "$folder" /tmp
cd /tmp
# The component among those that LinuxCNC came with, for this run.
mkdir shipped modules home
mount --bind "$LINUXCNC_MODULES" shipped
ln -s /tmp/shipped/* modules
ln -sf /tmp/component/caltwin.so modules/caltwin.so
mount --bind modules "$LINUXCNC_MODULES"
export HOME=/tmp/home
cd config
LD_PRELOAD=/tmp/time.so linuxcnc -r "./$ini" </dev/null 3<&- &
cat <&3 >/dev/null &
# A realtime process that dies while LinuxCNC starts is missed by nobody else.
until realtime=$(pgrep -x -o rtapi_app -P 1); do sleep 0.02; done && tail -s 0.2 -f /dev/null --pid "$realtime" 3<&- &
# Without its operator LinuxCNC cleans up, for up to 20 s, what goes with these namespaces.
until operator=$(pgrep -o -f caltwin_operator.py); do sleep 0.02; done && tail -s 0.2 -f /dev/null --pid "$operator" 3<&- &
wait -n
