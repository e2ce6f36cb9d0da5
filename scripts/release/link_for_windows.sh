#!/bin/sh
# Links as mingw's gcc does, without what dependencies export for themselves: rustc lists all of it in a .def file.
for argument; do
    case $argument in
    *.def) sed -i -E '/^ *"?fmi2/b; /^ /d' "${argument#-Wl,}" ;;
    esac
done
exec x86_64-w64-mingw32-gcc "$@"
