# A sensor in a container: the daemon and the commands about it, without the view.
#
#     docker build -t vsensor .
#     docker run -d --name well-b -p 7447:7447 -v /etc/vsensor:/etc/vsensor:ro -v well-b:/var/lib/vsensor \
#         -v vsensor-kernels:/var/cache/vsensor --group-add "$(stat -c %g /etc/vsensor)" \
#         vsensor run /etc/vsensor/well-b.toml
#
# The group is the host's: /etc/vsensor may be read by its group alone, and the user in here is another than the host's.
# Inside, listen on all addresses ("tls/0.0.0.0:7447", docs/security.md) and have [metrics] enabled, which the health
# check asks. docs/operations.md tells how to give it real-time priority.
FROM debian:bookworm-slim AS build
RUN apt-get update \
    && apt-get install -y --no-install-recommends python3 python3-venv \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /src
# The dependencies first: a change of our own does not install them again.
COPY constraints.txt pyproject.toml README.md LICENSE ./
RUN python3 -m venv /opt/vsensor \
    && /opt/vsensor/bin/python -c "import tomllib; print(*tomllib.load(open('pyproject.toml', 'rb'))['project']['dependencies'], sep='\n')" > needed.txt \
    && /opt/vsensor/bin/pip install --no-cache-dir --constraint constraints.txt --requirement needed.txt
COPY config config
COPY vsensor vsensor
RUN /opt/vsensor/bin/pip install --no-cache-dir --constraint constraints.txt . \
    && /opt/vsensor/bin/pip check \
    && find /opt/vsensor -type d -name tests -path '*/site-packages/*' -prune -exec rm -rf {} + \
    && /opt/vsensor/bin/pip uninstall --yes pip

FROM debian:bookworm-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends python3 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --system --uid 10001 --no-create-home --home-dir /var/lib/vsensor vsensor \
    && install -d -o vsensor -g vsensor -m 750 /var/lib/vsensor /var/cache/vsensor
COPY --from=build /opt/vsensor /opt/vsensor
# Kernels are compiled for the processor that runs them, at the first start: the volume keeps them for the next.
ENV PATH=/opt/vsensor/bin:$PATH NUMBA_CACHE_DIR=/var/cache/vsensor PYTHONDONTWRITEBYTECODE=1 PYTHONUNBUFFERED=1
USER vsensor
WORKDIR /var/lib/vsensor
VOLUME ["/var/lib/vsensor", "/var/cache/vsensor"]
EXPOSE 7447
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=5s --start-period=10m --retries=3 \
    CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:9464/livez', timeout=4)"]
ENTRYPOINT ["vsensor"]
CMD ["run", "/etc/vsensor/rig.toml"]
