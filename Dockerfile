# docker build -t fsipetsc . && docker run --rm -v "$PWD:/data" fsipetsc rod
FROM debian:bookworm-slim
COPY . /opt/fsipetsc
RUN /opt/fsipetsc/scripts/setup && rm -rf /var/lib/apt/lists/*
ENV FSIPETSC_CACHE=/opt/kernels OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
# kernels of three cases, for processors like this one; others compile theirs when they first run
RUN cd /tmp && \
    for case in rod box blast; do /opt/fsipetsc/scripts/run $case -ts_max_steps 1 -fsi_quiet || exit 1; done && rm *.h5 *.xdmf
WORKDIR /data
ENTRYPOINT ["/opt/fsipetsc/scripts/run"]
