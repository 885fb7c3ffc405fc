#!/usr/bin/env bash
# install_packages.sh GROUP… [+PACKAGE…]: installs the Debian packages of these groups of packages.txt, and those after a +,
# that are missing; needs root or sudo only if one is.
set -euo pipefail
cd "$(dirname "$0")"

wanted=()
for name in "$@"; do
  if [[ $name == +* ]]; then
    wanted+=("${name#+}")
    continue
  fi
  grep -qxF "[$name]" packages.txt || { echo "install_packages.sh: packages.txt has no group [$name]" >&2; exit 2; }
  mapfile -t -O ${#wanted[@]} wanted < <(awk -v group="[$name]" '/^\[/ { here = $0 == group; next } here && NF && !/^#/' packages.txt)
done

missing=()
for package in "${wanted[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "install_packages.sh: needs root or sudo to install: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "Installing ${#missing[@]} packages: ${missing[*]}"
"${as_root[@]}" apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}"
