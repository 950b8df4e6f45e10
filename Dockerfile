# The archive in the web browser. The server listens to this machine alone, so the container shares its network:
#   docker build -t tribopipe .
#   docker run --rm --network host -v "$PWD/archive:/archive" tribopipe
FROM python:3.13-slim
COPY . /src
RUN pip install --no-cache-dir --require-hashes -r /src/requirements/locked.txt \
    && pip install --no-cache-dir --no-deps /src && rm -r /src
WORKDIR /
EXPOSE 8765
CMD ["tribopipe", "browse", "--archive", "/archive", "--port", "8765", "--no-browser"]
