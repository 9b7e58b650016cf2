#!/bin/bash
#SBATCH --job-name=verify-replays
#SBATCH --array=0-15
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --time=04:00:00
# Verifies a list of replays as an array of 16 jobs; submitted from the folder with list.txt and the scripts:
#
#   mkdir -p results && sbatch --wait slurm.sh
#   cellstep verify --merge results/shard-*.jsonl
#
# Another number of shards: `sbatch --array=0-63 slurm.sh`. The array has to begin at 0.
set -eu
cd "${SLURM_SUBMIT_DIR:-.}"
exec "${FLEET:-.}/shard.sh" "$SLURM_ARRAY_TASK_ID" "$SLURM_ARRAY_TASK_COUNT" list.txt results
