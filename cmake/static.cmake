# Included by cmake right behind project() where scripts/dist.sh builds the tools of a release: archives of libraries come before shared ones.
set(CMAKE_FIND_LIBRARY_SUFFIXES .a .so)
