#!/usr/bin/env bash
# Builds the Containerfile with buildah and runs the sample recording in it, on a base made by mmdebstrap where no image can be pulled; needs
# root, buildah, mmdebstrap and a Debian mirror.
#   scripts/package/try_container.sh build/release/lake_….deb
set -euo pipefail
package=$(realpath "$1")
here=$(dirname "$(realpath "$0")")
work=$(mktemp -d)
store=(--root "$work/store" --runroot "$work/run" --storage-driver vfs)
trap 'rm -rf --one-file-system "$work"' EXIT

mkdir "$work/context"
cp "$package" "$work/context/"
# The mirror's settings of this machine go into the base, as apt needs them there.
mmdebstrap --variant=apt --setup-hook='mkdir -p "$1/etc/apt/apt.conf.d"; cp /etc/apt/apt.conf.d/* "$1/etc/apt/apt.conf.d/" 2>/dev/null || true' \
  bookworm "$work/base.tar"
base=$(buildah "${store[@]}" from scratch)
buildah "${store[@]}" add -q "$base" "$work/base.tar" / >/dev/null
buildah "${store[@]}" commit -q "$base" base >/dev/null
buildah "${store[@]}" build --isolation chroot --build-arg BASE=localhost/base --pull-never -f "$here/Containerfile" -t lake "$work/context"

container=$(buildah "${store[@]}" from --pull-never localhost/lake)
[ "$(buildah "${store[@]}" inspect --format '{{index .OCIv1.Config.Entrypoint 0}}' "$container")" = lake ]
inside() { buildah "${store[@]}" run --isolation chroot "$container" -- lake "$@"; }
inside --version
inside track /usr/share/doc/lake/examples/data/sts-study/human.mp4 --camera /usr/share/doc/lake/examples/data/sts-study/camera.yaml --end 4 -o /tmp/human
inside info /tmp/human
