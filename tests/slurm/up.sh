#!/bin/bash
# Starts a Slurm cluster of this one machine that listens on 127.0.0.1 only: no systemd, no cgroups, no database.
# Usage, as root: up.sh DIR [PORT]; then export SLURM_CONF=DIR/slurm.conf. down.sh DIR stops what this started.
# Everything lives in DIR, munge's key and socket as well: other clusters on this machine are not disturbed.
# Needs: apt-get install --no-install-recommends slurm-wlm munge
set -euo pipefail
dir=$(realpath -m "${1:?up.sh DIR [PORT]}")
port=${2:-16817}
host=$(hostname -s)
mkdir -p "$dir"/{state,spool}

# "NodeName=vm CPUs=2 Boards=1 SocketsPerBoard=1 CoresPerSocket=2 ThreadsPerCore=1 RealMemory=24105"
found=$(slurmd -C | head -n 1)
node=${found% RealMemory=*}
memory=$(( ${found##*RealMemory=} * 8 / 10 ))
cat > "$dir/slurm.conf" <<CONF
ClusterName=solo
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge.socket
# Binds to the addresses above instead of to all.
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmctldPort=$port
SlurmdPort=$((port + 1))
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc=$dir/jobcomp.txt
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_min_interval=10000
ReturnToService=2
KillWait=30
MinJobAge=3600
$node NodeAddr=127.0.0.1 RealMemory=$memory State=UNKNOWN
PartitionName=render Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF

( umask 077 && head -c 1024 /dev/urandom > "$dir/munge.key" )
# --force: as root, and under /tmp.
munged --force --key-file="$dir/munge.key" --socket="$dir/munge.socket" --pid-file="$dir/munged.pid" \
    --log-file="$dir/munged.log" --seed-file="$dir/munged.seed" 2>/dev/null
slurmctld -f "$dir/slurm.conf"
slurmd -f "$dir/slurm.conf" -N "$host"
export SLURM_CONF=$dir/slurm.conf
for _ in {1..100}; do
    if sinfo --noheader --format=%t 2>/dev/null | grep -q idle; then exit 0; fi
    sleep 0.2
done
echo "the node does not become idle; see $dir/slurmctld.log and $dir/slurmd.log" >&2
exit 1
