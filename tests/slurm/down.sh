#!/bin/bash
# Stops what up.sh DIR started, by process id.
dir=$(realpath "${1:?down.sh DIR}")
for daemon in slurmd slurmctld munged; do
    pid=$(cat "$dir/$daemon.pid" 2>/dev/null) || continue
    kill "$pid"
    for _ in {1..50}; do
        kill -0 "$pid" 2>/dev/null || break
        sleep 0.2
    done
done
exit 0
