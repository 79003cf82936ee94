#!/usr/bin/env bash
# A certificate authority of your own, and a certificate for each role on the bus.
#
#     config/zenoh/make-authority.sh FOLDER [HOST ...]
#
# HOST: names and addresses at which clients reach the daemon or router; localhost and 127.0.0.1 are always in.
# Run again, it keeps the authority and every certificate that is there, and makes what is missing: to renew a
# role, remove its .pem and .key first. Made for tests and a single rig. Whoever holds ca.key can let anyone in:
# on a rig, keep it on another machine, or take certificates from your company's authority. What the access
# control goes by is the certificate's common name (CN), here the role's.
set -euo pipefail
umask 077

if [ $# -lt 1 ] || [[ $1 == -* ]]; then
    echo "usage: $0 FOLDER [HOST ...]" >&2
    exit 2
fi
mkdir -p "$1"
cd "$1"
shift

names="DNS:localhost,IP:127.0.0.1"
for host in "$@"; do
    if [[ $host =~ ^[0-9.]+$ || $host == *:* ]]; then names+=",IP:$host"; else names+=",DNS:$host"; fi
done

# What is made comes to its place when it is whole, and what openssl says is told where it fails.
made=$(mktemp -d .made.XXXXXX)
trap 'rm -rf "$made"' EXIT
quietly() { "$@" 2> "$made/said" || { cat "$made/said" >&2; exit 1; }; }
new_key() { quietly openssl genpkey -quiet -algorithm EC -pkeyopt ec_paramgen_curve:P-256 -out "$1"; }

if [ ! -s ca.key ]; then
    new_key "$made/ca.key"
    quietly openssl req -x509 -new -key "$made/ca.key" -days 3650 -subj "/CN=vsensor authority" -out "$made/ca.pem" \
        -addext "basicConstraints=critical,CA:TRUE,pathlen:0" -addext "keyUsage=critical,keyCertSign,cRLSign"
    chmod a+r "$made/ca.pem"
    mv "$made/ca.key" "$made/ca.pem" .
fi

# Who serves is asked for its names; who connects is not.
for role in daemon router sensor surface viewer driller; do
    if [ -s "$role.pem" ]; then continue; fi
    case $role in
        daemon | router) extensions="extendedKeyUsage=serverAuth,clientAuth"$'\n'"subjectAltName=$names" ;;
        *) extensions="extendedKeyUsage=clientAuth" ;;
    esac
    new_key "$made/$role.key"
    quietly openssl req -new -key "$made/$role.key" -subj "/CN=$role" -out "$made/$role.csr"
    printf 'basicConstraints=critical,CA:FALSE\nkeyUsage=critical,digitalSignature\n%s\n' "$extensions" > "$made/extensions"
    quietly openssl x509 -req -in "$made/$role.csr" -CA ca.pem -CAkey ca.key -CAcreateserial -days 825 \
        -out "$made/$role.pem" -extfile "$made/extensions"
    chmod a+r "$made/$role.pem"
    mv "$made/$role.key" "$made/$role.pem" .
    echo "$role.pem, $role.key"
done
