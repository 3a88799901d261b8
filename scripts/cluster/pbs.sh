#!/bin/bash
# A run in a chain of PBS's jobs (docs/cluster.md): each goes on from the checkpoint of the one before.
#
#   qsub -v RUN="CASE [options]" scripts/cluster/pbs.sh
#
#PBS -N fsipetsc
#PBS -l select=1:ncpus=16:mpiprocs=16
#PBS -l walltime=04:00:00

cd "$PBS_O_WORKDIR" || exit 2
export OMP_NUM_THREADS=1
# Open MPI 4 and 5: so long ranks may take to write their checkpoint [s]
export OMPI_MCA_odls_base_sigkill_timeout=60 PRTE_MCA_odls_base_sigkill_timeout=60
# PBS gives a job a few seconds when its time is over, so the run is stopped 4 minutes before
timeout -s TERM "${LIMIT:-236m}" mpiexec --map-by core --bind-to core \
    python -m fsipetsc $RUN -fsi_checkpoint_wall 600 -fsi_restart auto
status=$?
# SIGTERM has ended it, and the next job goes on; an error ends the chain
[ $status -eq 124 ] && exit 0
exit $status
