#!/bin/bash
# A run in a chain of Slurm's jobs (docs/cluster.md): each goes on from the checkpoint of the one before.
#
#   sbatch scripts/cluster/slurm.sh CASE [options]
#
#SBATCH --job-name=fsipetsc
#SBATCH --nodes=1
#SBATCH --ntasks=16
#SBATCH --cpus-per-task=1
#SBATCH --hint=nomultithread
#SBATCH --time=04:00:00
#SBATCH --signal=TERM@120

export OMP_NUM_THREADS=1
srun --cpu-bind=cores python -m fsipetsc "$@" -fsi_checkpoint_wall 600 -fsi_restart auto
status=$?
# SIGTERM has ended it, and the next job goes on; an error ends the chain
[ $status -eq 143 ] && exit 0
exit $status
