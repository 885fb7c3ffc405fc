#!/usr/bin/env bash
# Installs a package in a bare Debian 12 and runs the sample study there as a user would; needs root, mmdebstrap and a Debian mirror.
#   scripts/package/try.sh build/release/lake_….deb
set -euo pipefail
package=$(realpath "$1")
system=$(mktemp -d)
trap 'umount "$system/proc" 2>/dev/null; rm -rf --one-file-system "$system"' EXIT

mmdebstrap --variant=apt --hook-dir=/usr/share/mmdebstrap/hooks/file-mirror-automount --include="$package" bookworm "$system"
mount -t proc proc "$system/proc"
chroot "$system" lake --version
chroot "$system" lake run /usr/share/doc/lake/examples/data/sts-study/study.yaml -o /root/study
test -s "$system/root/study/report.html"
chroot "$system" python3 -c "import lake; assert lake.read('/root/study/human').table('events')['event'][0] == 'onset'"
