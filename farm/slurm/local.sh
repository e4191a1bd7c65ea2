#!/bin/bash
# A cluster of one node on this machine, for trying out the scripts beside this one: munge, slurmctld and slurmd on the
# loopback interface, with all state in one folder.
#
#   local.sh start FOLDER [CPUS]   starts it; then: export SLURM_CONF=FOLDER/slurm.conf
#   local.sh stop FOLDER           stops all of it
#
# Needs root, and the packages slurm-wlm and munge (Debian). Many clusters may run at a time if SLURM_TEST_PORT differs.
set -euo pipefail

fail() {
    echo "error: $*" >&2
    exit 1
}

[ $# -ge 2 ] || fail "usage: local.sh start|stop FOLDER [CPUS]"
folder=$(realpath -m "$2")
cpus=${3:-4}
port=${SLURM_TEST_PORT:-17817}
daemons="slurmd slurmctld munged"

# Waits up to 20 s for a command to succeed.
wait_for() {
    for _ in $(seq 200); do
        if timeout 5 "$@" >/dev/null 2>&1; then return 0; fi
        sleep 0.1
    done
    return 1
}

# Ends each process by the number in its file: asked first, then killed.
stop() {
    if [ -f "$folder/slurm.conf" ]; then
        SLURM_CONF=$folder/slurm.conf timeout 5 scancel --user=root 2>/dev/null || true
        sleep 1
    fi
    for name in $daemons; do
        [ -f "$folder/$name.pid" ] || continue
        pid=$(cat "$folder/$name.pid")
        # The file may be older than the system.
        [ "$(cat "/proc/$pid/comm" 2>/dev/null)" = "$name" ] || continue
        kill "$pid" 2>/dev/null || true
        wait_for sh -c "! kill -0 $pid" || kill -KILL "$pid" 2>/dev/null || true
        rm -f "$folder/$name.pid"
    done
}

start() {
    [ "$(id -u)" = 0 ] || fail "a cluster of one's own needs root"
    for program in munged slurmctld slurmd; do
        PATH=$PATH:/usr/sbin command -v $program >/dev/null || fail "$program is missing; get it with: apt-get install slurm-wlm munge"
    done
    export PATH=$PATH:/usr/sbin
    mkdir -p "$folder"/{state,spool,log}
    chmod 755 "$folder"
    host=$(hostname -s)
    ( umask 077; head -c 1024 /dev/urandom >"$folder/munge.key" )
    cat >"$folder/slurm.conf" <<END
ClusterName=glanz
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
AuthType=auth/munge
# A task that is queued again waits until its credentials expire.
AuthInfo=socket=$folder/munge.socket,cred_expire=5
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/log/slurmctld.log
SlurmdLogFile=$folder/log/slurmd.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
MailProg=/bin/true
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=0
KillWait=30
MinJobAge=600
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus State=UNKNOWN
PartitionName=local Nodes=$host Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
END
    munged --key-file="$folder/munge.key" --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
        --log-file="$folder/log/munged.log" --seed-file="$folder/munge.seed" --force
    export SLURM_CONF=$folder/slurm.conf
    slurmctld -c
    wait_for scontrol ping || fail "slurmctld does not answer; see $folder/log/slurmctld.log"
    slurmd
    wait_for sh -c 'sinfo -h -o %t | grep -qE "idle|mix"' || fail "the node is not ready; see $folder/log"
    echo "export SLURM_CONF=$folder/slurm.conf"
}

case $1 in
    start) trap '[ $? = 0 ] || stop' EXIT; start ;;
    stop) stop ;;
    *) fail "usage: local.sh start|stop FOLDER [CPUS]" ;;
esac
