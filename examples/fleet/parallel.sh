#!/usr/bin/env bash
# Verifies a list of replays with GNU parallel, and prints what one run would: parallel.sh LIST RESULTS SHARDS
#
# RESULTS is a new folder. Options for parallel, such as `--sshloginfile`, go into the variable PARALLEL. A shard that
# did not come back is an error: `cellstep verify --merge` wants all of them. The exit code is that of one run.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
list=$1 results=$2 shards=$3
mkdir "$results"
seq 0 "$((shards - 1))" | parallel --retries 3 "$here/shard.sh" {} "$shards" "$list" "$results"
"${CELLSTEP:-cellstep}" verify --merge "$results"/shard-*.jsonl
