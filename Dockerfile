# SPDX-License-Identifier: Apache-2.0
# The command in a container, with ONNX Runtime and the networks; what is built with stays in the first stage.
#   docker build --tag estancia .
#   docker run --rm --volume "$PWD:/data" estancia map photos -o home.estancia
#   docker run --rm --volume "$PWD:/data" --device /dev/video0 --group-add video --publish 127.0.0.1:8765:8765 \
#     estancia live 0 -o home.estancia --listen 0.0.0.0 --port 8765
ARG BASE=debian:12-slim

FROM ${BASE} AS build
ENV ESTANCIA_HOME=/opt/estancia DEBIAN_FRONTEND=noninteractive
WORKDIR /source/estancia
COPY debian/control debian/
RUN apt-get update \
 && apt-get build-dep --yes --no-install-recommends ./ \
 && apt-get install --yes --no-install-recommends ca-certificates npm
COPY . .
RUN script/bootstrap --headers
RUN dpkg-buildpackage --build=binary --no-sign \
 && mkdir /packages && mv ../estancia_*.deb ../libestancia0_*.deb ../estancia-odometry_*.deb /packages

FROM ${BASE}
COPY --from=build /packages /packages
RUN apt-get update \
 && apt-get install --yes --no-install-recommends /packages/*.deb ca-certificates wordnet-base \
 && rm -rf /packages /var/lib/apt/lists/* \
 && useradd --uid 1000 --home-dir /data robot && install --directory --owner robot /data
COPY --from=build /opt/estancia/models /opt/estancia/models
COPY --from=build /opt/estancia/onnxruntime/lib /opt/estancia/onnxruntime/lib
ENV ESTANCIA_HOME=/opt/estancia HOME=/data
RUN estancia models list | grep --word-regexp onnxruntime # the faster engine was compiled in, and opens
USER robot
WORKDIR /data
ENTRYPOINT ["estancia"]
CMD ["--help"]
