# The program and the library of its FMUs, in an image without a compiler.
FROM rust:1-slim AS build
WORKDIR /rimbench
COPY . .
RUN cargo build --release --locked
FROM debian:stable-slim
COPY --from=build /rimbench/target/release/rimbench /rimbench/target/release/librimbench_fmi.so /usr/local/bin/
WORKDIR /work
ENTRYPOINT ["rimbench"]
