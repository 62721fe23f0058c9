#!/usr/bin/env bash
# A real Slurm cluster of one node on this machine, without systemd: for what submits jobs and has to survive a node that dies.
#
#   slurm_cluster.sh start DIR        installs Slurm where it is missing, starts it with all of its state in DIR, and prints `export SLURM_CONF=…`
#   slurm_cluster.sh kill-node DIR    kills the node's daemon and everything that it runs, as a power failure does
#   slurm_cluster.sh revive-node DIR  starts the daemon again
#   slurm_cluster.sh stop DIR         ends all of it
#
# It needs to be root: the node's daemon changes users, and the key of munge has to belong to it.
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
    # The packages would start services; nobody wants those of the system here.
    printf '#!/bin/sh\nexit 101\n' >/usr/sbin/policy-rc.d && chmod +x /usr/sbin/policy-rc.d
    DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends slurmctld slurmd slurm-client munge >&2
    rm -f /usr/sbin/policy-rc.d
}

# All of memory but a gibibyte, which the machine itself needs.
memory() { awk '/MemTotal/ { print int($2 / 1024) - 1024 }' /proc/meminfo; }

configure() {
    # One node that is its own controller; memory is shared out, nothing asks for control groups, and a dead node is noticed in seconds.
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

# Waits until the node takes jobs.
await_node() {
    for _ in $(seq 60); do
        case "$(sinfo --noheader --format=%T 2>/dev/null)" in
        idle | mixed | allocated) return ;;
        down*) scontrol update NodeName=localhost State=RESUME 2>/dev/null || true ;;
        esac
        sleep 1
    done
    say "the node does not come up; $folder/slurmctld.log and $folder/slurmd.log say why"
    exit 1
}

# The process of a pid file, and all of its children.
kill_tree() {
    local child
    for child in $(pgrep -P "$1" || true); do kill_tree "$child"; done
    kill -9 "$1" 2>/dev/null || true
}

kill_node() {
    # Steps are no children of the daemon, so that they outlive it; a power failure spares nobody.
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
