#!/bin/sh
# The camera draws with OpenGL. On Linux without a display it needs EGL (or OSMesa) with Mesa's software driver:
# install them where that is possible (Debian and its children, as root), otherwise print the one command to type.
set -u
PATH=$PATH:/sbin:/usr/sbin # ldconfig is there, and an ordinary user has no such path
packages="libegl1 libopengl0 libgl1 libgl1-mesa-dri"
[ "$(uname -s)" = Linux ] || exit 0
have() { ldconfig -p 2>/dev/null | grep -q "$1"; }
if { have libEGL.so.1 && { have libOpenGL.so.0 || have libGL.so.1; }; } || have libOSMesa.so; then exit 0; fi
command="apt-get update && apt-get install -y --no-install-recommends $packages"
if command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" = 0 ]; then
    echo "installing the OpenGL software renderer: $packages"
    apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages >/dev/null && exit 0
fi
if command -v apt-get >/dev/null 2>&1; then
    echo "The camera needs an OpenGL library. Please type:  sudo sh -c '$command'" >&2
else
    echo "The camera needs libEGL with Mesa's software driver (or libOSMesa): install it with your package manager." >&2
fi
exit 0
