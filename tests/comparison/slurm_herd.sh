#!/usr/bin/env bash
# Compares the output of a herd on Slurm with that by Ninja, also after failures of commands, the node and the disk.
#
#   slurm_herd.sh PELAGE DIR    runs all checks with that program in that folder, as root; exits with 1 on a difference
set -euo pipefail

say() { printf '%s\n' "$*"; }

if [ $# -ne 2 ]; then
    sed -n '4s/^# *//p' "$0" >&2
    exit 1
fi
here=$(cd "$(dirname "$0")" && pwd)
pelage=$(realpath "$1")
mkdir -p "$2"
folder=$(cd "$2" && pwd)
herd=$folder/herd.toml
models=$here/../../assets/models
failed=0

cluster() { "$here/slurm_cluster.sh" "$1" "$folder/cluster"; }

# hashes FOLDER: prints the hashes of a herd's output, without its internal files and its report. Temporary files that
# are left behind count as output, so that they are found.
hashes() (
    cd "$1" && find packages pictures truths differences sequences -type f | LC_ALL=C sort | xargs -d '\n' sha256sum
)

same() {
    if hashes "$folder/$2" 2>&1 | diff -q - "$folder/expected" >/dev/null; then
        say "same bytes: $1"
    else
        say "DIFFERENT BYTES: $1"
        hashes "$folder/$2" 2>&1 | diff - "$folder/expected" | head -5
        failed=1
    fi
}

# run NAME OPTION...: runs the herd into the folder NAME.
run() {
    local name=$1
    shift
    "$pelage" herd run "$herd" -o "$folder/$name" --quiet "$@"
}

on_slurm() {
    local name=$1
    shift
    run "$name" --engine slurm --shard-seconds 4 "$@"
}

# made FOLDER: prints the number of packages and images in a folder.
made() { find "$1" \( -name '*.pelage' -o -name '*.png' \) 2>/dev/null | wc -l; }

# await NAME COUNT: waits until a running herd has made COUNT packages and images.
await() { for _ in $(seq 600); do if [ "$(made "$folder/$1")" -ge "$2" ]; then return; fi; sleep 0.1; done; }

# Kills two running commands. Polls for them, because at times no command is running.
kill_two() {
    local killed=0 process
    for _ in $(seq 2000); do
        process=$(pgrep -f "^$pelage (bake|render|reference)" | head -1) || true
        if [ -n "$process" ] && kill -9 "$process" 2>/dev/null; then killed=$((killed + 1)); fi
        if [ "$killed" = 2 ]; then return; fi
        sleep 0.02
    done
}

ran() { sed -n 's/ commands were run.*//p'; }

mkdir -p "$folder/models"
cp "$models"/{torus,knot,ox,crane}.glb "$folder/models"
cat >"$herd" <<'TOML'
[[model]]
files = "models/*.glb"
[[recipe]]
set = { slice = { tile_texels = 64, layers = 8 } }
[[variant]]
name = "a"
[[variant]]
name = "b"
set = { "hair.lean" = 0.6 }
[[variant]]
name = "c"
set = { "hair.coat" = "wet" }
[[view]]
name = "front"
size = "128x128"
[view.truth]
samples = 4
parts = 2
[[sequence]]
name = "turn"
models = "torus.glb"
view = "front"
frames = 8
shares = 2
auto_rotate = true
TOML

trap 'cluster stop 2>/dev/null || true; mountpoint -q "$folder/full" && umount "$folder/full"; true' EXIT
eval "$(cluster start)"

begun=$(date +%s.%N)
say "ninja: $(run ninja --jobs 2 | ran) commands in $(echo "$(date +%s.%N) - $begun" | bc) s"
hashes "$folder/ninja" >"$folder/expected"

begun=$(date +%s.%N)
commands=$(on_slurm slurm | ran) seconds=$(echo "$(date +%s.%N) - $begun" | bc)
say "slurm: $commands commands in $seconds s, $(find "$folder/slurm/.herd/slurm" -name '*.done' | wc -l) shards"
same "a herd on Slurm" slurm
say "again: $(on_slurm slurm | ran) commands"

# Commands are killed from outside: their shards retry them.
on_slurm task >"$folder/task.txt" &
await task 3
kill_two
wait $! || true
say "two commands were killed: $(tail -2 "$folder/task.txt" | head -1)"
same "after commands were killed" task

# Without retries, and without a process that waits, the report finds killed commands in the logs of the cluster.
on_slurm dead --retries 0 --detach >/dev/null
await dead 3
kill_two
while [ -n "$(squeue --noheader)" ]; do sleep 1; done
told=$("$pelage" herd report "$herd" -o "$folder/dead" --quiet 2>&1 | grep -c 'it ended without a' || true)
say "killed for good: the report lists $told commands"
[ "$told" -gt 0 ] || failed=1
say "after another run: $(on_slurm dead | tail -2 | head -1)"
same "after commands were killed for good" dead

# The node dies with everything that runs on it. Its shards return to the queue and restart when the node is back.
on_slurm node >"$folder/node.txt" &
await node 4
cluster kill-node
sleep 15
say "while the node is away: $(sinfo --noheader --format=%T), $(made "$folder/node") files"
cluster revive-node
wait $! || true
say "the node died: $(tail -2 "$folder/node.txt" | head -1)"
say "temporary files left behind: $(find "$folder/node" -name '.pelage-*' | wc -l)"
find "$folder/node" -name '.pelage-*' -delete
same "after the node died" node

# The disk fills up during the run.
mkdir -p "$folder/full"
mount -t tmpfs -o size=12m tmpfs "$folder/full"
code=$(on_slurm full >"$folder/full.txt" 2>&1; echo $?) full=$(grep -c 'No space left' "$folder/full.txt" || true)
say "on a disk of 12 MiB: exit code $code, $full messages report a full disk"
mount -o remount,size=2g "$folder/full"
say "with enough space: $(on_slurm full | tail -2 | head -1)"
same "after the disk was full" full

exit "$failed"
