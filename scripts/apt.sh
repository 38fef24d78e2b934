#!/usr/bin/env bash
# What the other scripts need to know of apt. Sourced, not run.
#
# Nothing here names a mirror: addresses, keys and options always come from the
# sources that the machine has, so the scripts work behind any mirror.

# Where apt's settings are; only tests look elsewhere.
apt_folder=${RAMUS_APT_FOLDER:-/etc/apt}

# Runs a command as root: directly, or by sudo where there is one.
as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif command -v sudo >/dev/null 2>&1; then
        sudo "$@"
    else
        echo "this needs root: run it as root once, or install sudo: $*" >&2
        return 1
    fi
}

# True when every named Debian package is installed.
installed() {
    local package
    for package in "$@"; do
        [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || return 1
    done
}

# Prints the first apt source that carries suite $1, with its suites replaced by $2.
# A deb822 stanza keeps its other fields (Signed-By, Architectures, an inline key …),
# a one-line entry its options. Line 1 says which kind it is: "sources" or "list".
apt_source_for() {
    local suite=$1 wanted=$2 file found
    for file in "$apt_folder"/sources.list.d/*.sources; do
        [ -r "$file" ] || continue
        found=$(awk -v suite="$suite" -v wanted="$wanted" '
            function flush() {
                if (fits && binary && !disabled && !done) { printf "%s", stanza; done = 1 }
                stanza = ""; fits = 0; binary = 0; disabled = 0
            }
            /^[ \t]*$/ { flush(); next }
            /^#/ { next }
            tolower($1) == "types:" { for (i = 2; i <= NF; i++) if ($i == "deb") binary = 1; $0 = "Types: deb" }
            tolower($1) == "enabled:" { if (tolower($2) == "no") disabled = 1 }
            tolower($1) == "suites:" { for (i = 2; i <= NF; i++) if ($i == suite) fits = 1; $0 = "Suites: " wanted }
            { stanza = stanza $0 "\n" }
            END { flush() }' "$file")
        if [ -n "$found" ]; then
            printf 'sources\n%s\n' "$found"
            return 0
        fi
    done
    for file in "$apt_folder"/sources.list "$apt_folder"/sources.list.d/*.list; do
        [ -r "$file" ] || continue
        # deb [options] address suite component…
        found=$(awk -v suite="$suite" -v wanted="$wanted" '
            $1 == "deb" {
                at = 2
                if ($2 ~ /^\[/) { while (at <= NF && $at !~ /\]$/) at++; at++ }
                if ($(at + 1) == suite) { $(at + 1) = wanted; print; exit }
            }' "$file")
        if [ -n "$found" ]; then
            printf 'list\n%s\n' "$found"
            return 0
        fi
    done
    return 1
}

# Prints the address of the first apt source that carries suite $1.
apt_address_for() {
    apt_source_for "$1" "$1" | awk '
        NR == 1 { kind = $1; next }
        kind == "sources" && tolower($1) == "uris:" { print $2; exit }
        kind == "list" { at = 2; if ($2 ~ /^\[/) { while (at <= NF && $at !~ /\]$/) at++; at++ } print $at; exit }'
}

# Prints the key file that the source of suite $1 is signed by, where it names one.
apt_key_for() {
    apt_source_for "$1" "$1" | awk '
        NR == 1 { kind = $1; next }
        kind == "sources" && tolower($1) == "signed-by:" && $2 ~ /^\// { print $2; exit }
        kind == "list" && match($0, /signed-by=[^] ,]*/) { print substr($0, RSTART + 10, RLENGTH - 10); exit }'
}

# quietly LOG WHAT COMMAND…: one line for a long command, with its time; where it fails, the end of its log.
quietly() {
    local log=$1 what=$2 began=$SECONDS
    shift 2
    printf '%s … ' "$what"
    if "$@" >>"$log" 2>&1 </dev/null; then
        printf '%s s\n' $((SECONDS - began))
    else
        printf 'failed; the end of %s:\n' "$log"
        tail -n 25 "$log"
        return 1
    fi
}
