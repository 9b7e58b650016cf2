#!/bin/sh
# Verifies one shard of a list of replays: shard.sh INDEX COUNT LIST RESULTS
#
# LIST has a replay's path on each line, the same for all shards. The answers go to RESULTS/shard-INDEX.jsonl, which is
# there only when the shard is done. Replays that diverge or are corrupt are answers; what could not be read (exit code
# 2) is none, so that a job is tried again. CELLSTEP is the command, `cellstep` if it is not set.
set -eu
index=$1 count=$2 list=$3 results=$4
done="$results/shard-$index.jsonl"
part="$done.part"
code=0
"${CELLSTEP:-cellstep}" verify --list "$list" --shard "$index/$count" --workers "${WORKERS:-1}" >"$part" || code=$?
case $code in
    0 | 1 | 3 | 4) mv "$part" "$done" ;;
    *) exit "$code" ;;
esac
