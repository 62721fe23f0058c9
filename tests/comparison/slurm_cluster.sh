#!/usr/bin/env bash
# Runs a real Slurm cluster of one node on this machine, without systemd, to test job submission and the loss of a node.
#
#   slurm_cluster.sh start DIR        installs Slurm if missing, starts it in DIR, and prints `export SLURM_CONF=…`
#   slurm_cluster.sh kill-node DIR    kills the node's daemon and everything that it runs, like a power failure
#   slurm_cluster.sh revive-node DIR  starts the daemon again
#   slurm_cluster.sh stop DIR         stops everything
#
# Requires root: the node's daemon switches users, and munge must own its key.
set -euo pipefail

say() { printf '%s\n' "$*" >&2; }

usage() {
    sed -n '4,7s/^# *//p' "$0" >&2
    exit 1
}

[ $# -eq 2 ] || usage
action=$1
mkdir -p "$2"
folder=$(cd "$2" && pwd)
export SLURM_CONF=$folder/slurm.conf
socket=$folder/munge.socket

install_slurm() {
    if command -v slurmctld slurmd munged sbatch >/dev/null; then return; fi
    say "installing Slurm and munge"
    # Prevents the packages from starting their system services.
    printf '#!/bin/sh\nexit 101\n' >/usr/sbin/policy-rc.d && chmod +x /usr/sbin/policy-rc.d
    DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends slurmctld slurmd slurm-client munge >&2
    rm -f /usr/sbin/policy-rc.d
}

# Prints the node's memory, MiB: all except 1 GiB, which the machine itself needs.
memory() { awk '/MemTotal/ { print int($2 / 1024) - 1024 }' /proc/meminfo; }

configure() {
    # One node, which is also the controller. Memory is a consumable resource, control groups are not used, and a dead
    # node is detected within seconds.
    cat >"$SLURM_CONF" <<CONF
ClusterName=pelage
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
AuthType=auth/munge
AuthInfo=socket=$socket
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=sched_interval=2,bf_interval=2,sched_min_interval=100000
MinJobAge=3600
MaxArraySize=10001
JobRequeue=1
KillWait=2
SlurmdTimeout=10
ReturnToService=2
NodeName=localhost NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$(memory) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
}

start_node() { slurmd -N localhost; }

# Waits until the node accepts jobs.
await_node() {
    for _ in $(seq 60); do
        case "$(sinfo --noheader --format=%T 2>/dev/null)" in
        idle | mixed | allocated) return ;;
        down*) scontrol update NodeName=localhost State=RESUME 2>/dev/null || true ;;
        esac
        sleep 1
    done
    say "the node does not start; see $folder/slurmctld.log and $folder/slurmd.log"
    exit 1
}

# kill_tree PID: kills a process and all its descendants.
kill_tree() {
    local child
    for child in $(pgrep -P "$1" || true); do kill_tree "$child"; done
    kill -9 "$1" 2>/dev/null || true
}

kill_node() {
    # Job steps are not children of the daemon and would outlive it, unlike in a power failure.
    for step in $(pgrep -f "slurmstepd: \[" || true); do kill_tree "$step"; done
    if [ -f "$folder/slurmd.pid" ]; then kill_tree "$(cat "$folder/slurmd.pid")"; fi
    rm -f "$folder/slurmd.pid"
}

case "$action" in
start)
    install_slurm
    mkdir -p "$folder/state" "$folder/spool"
    configure
    dd if=/dev/urandom of="$folder/munge.key" bs=1024 count=1 2>/dev/null
    chmod 400 "$folder/munge.key"
    munged --force --key-file="$folder/munge.key" --socket="$socket" --pid-file="$folder/munged.pid" \
        --log-file="$folder/munged.log" --seed-file="$folder/munge.seed" 2>/dev/null
    slurmctld -c
    start_node
    await_node
    printf 'export SLURM_CONF=%q\n' "$SLURM_CONF"
    ;;
kill-node) kill_node ;;
revive-node)
    start_node
    await_node
    ;;
stop)
    kill_node
    for daemon in slurmctld munged; do
        if [ -f "$folder/$daemon.pid" ]; then kill "$(cat "$folder/$daemon.pid")" 2>/dev/null || true; fi
    done
    ;;
*) usage ;;
esac
