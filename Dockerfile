# morph on Debian's own Python, with the commands and a C compiler for its kernels.
#
#   docker build -t morph .
#   docker build -t morph:all --build-arg EXTRAS=all .
#   docker run --rm --user "$(id -u)" -v "$PWD:/data" morph diagnose pendulum run.csv --out found
FROM debian:bookworm-slim AS python
RUN apt-get update \
    && apt-get install --yes --no-install-recommends gcc libc6-dev python3-venv \
    && rm -rf /var/lib/apt/lists/* \
    && python3 -m venv /srv/morph

FROM python AS wheel
COPY . /source
RUN /srv/morph/bin/pip wheel --no-cache-dir --no-deps --wheel-dir /wheels /source

FROM python
# One or more of those in pyproject.toml, such as learn,view.
ARG EXTRAS=""
COPY --from=wheel /wheels /wheels
RUN wheel=$(ls /wheels/*.whl) \
    && /srv/morph/bin/pip install --no-cache-dir "${wheel}${EXTRAS:+[$EXTRAS]}" \
    && rm -r /wheels
ENV PATH=/srv/morph/bin:$PATH
# Files that morph writes belong to who runs it, who need not exist in the image.
ENV HOME=/tmp XDG_CACHE_HOME=/tmp/cache
WORKDIR /data
USER 1000
ENTRYPOINT ["morph"]
CMD ["--help"]
