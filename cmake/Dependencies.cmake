# Every third-party package is found here and nowhere else.
# The parallel HDF5 must be found first: other packages look for the serial one.
set(HDF5_PREFER_PARALLEL TRUE)
find_package(MPI REQUIRED COMPONENTS C)
find_package(HDF5 REQUIRED COMPONENTS C)
if(NOT HDF5_IS_PARALLEL)
  message(FATAL_ERROR "HDF5 with MPI is needed: install libhdf5-openmpi-dev")
endif()
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(PETSC REQUIRED IMPORTED_TARGET PETSc)
pkg_check_modules(MUPARSER REQUIRED IMPORTED_TARGET muparser)
find_path(SUITESPARSE_INCLUDE cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_library(UMFPACK_LIBRARY umfpack REQUIRED)

# PT-Scotch partitions the graphs of general meshes, through PETSc; Scotch itself is asked for repeatable parts.
find_path(PTSCOTCH_INCLUDE ptscotch.h PATH_SUFFIXES scotch)
find_library(PTSCOTCH_LIBRARY ptscotch)

# gmsh reads mesh files, in fbi-gen alone.
if(FBI_GMSH)
  find_path(GMSH_INCLUDE gmsh.h)
  find_library(GMSH_LIBRARY gmsh)
  if(NOT GMSH_INCLUDE OR NOT GMSH_LIBRARY)
    message(FATAL_ERROR "gmsh is needed to read mesh files: install libgmsh-dev, or configure with -DFBI_GMSH=OFF for a fbi-gen that cannot read them")
  endif()
endif()

add_library(fbi_options INTERFACE)
target_include_directories(fbi_options INTERFACE ${PROJECT_SOURCE_DIR}/libfbi ${PROJECT_SOURCE_DIR})
target_compile_definitions(fbi_options INTERFACE OMPI_SKIP_MPICXX)
# g++ 12 warns falsely about its own vector headers and about string concatenation.
target_compile_options(fbi_options INTERFACE -Wall -Wextra -Wno-unknown-pragmas
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-uninitialized -Wno-restrict>)
target_link_libraries(fbi_options INTERFACE MPI::MPI_C Eigen3::Eigen)
if(FBI_NATIVE)
  target_compile_options(fbi_options INTERFACE -march=native)
else()
  # The kernels of the linear solver are compiled for several processors, the best one is taken at run time.
  target_compile_definitions(fbi_options INTERFACE FBI_PORTABLE)
endif()
if(FBI_SANITIZE)
  target_compile_options(fbi_options INTERFACE -fsanitize=address,undefined -fno-omit-frame-pointer)
  target_link_options(fbi_options INTERFACE -fsanitize=address,undefined)
  target_sources(fbi_options INTERFACE
    "$<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:${PROJECT_SOURCE_DIR}/cmake/sanitizer_defaults.cpp>")
endif()

add_library(fbi_hdf5 INTERFACE)
target_include_directories(fbi_hdf5 SYSTEM INTERFACE ${HDF5_INCLUDE_DIRS})
target_link_libraries(fbi_hdf5 INTERFACE ${HDF5_LIBRARIES})

add_library(fbi_ptscotch INTERFACE)
if(PTSCOTCH_INCLUDE AND PTSCOTCH_LIBRARY)
  target_compile_definitions(fbi_ptscotch INTERFACE FBI_PTSCOTCH)
  target_include_directories(fbi_ptscotch SYSTEM INTERFACE ${PTSCOTCH_INCLUDE})
  target_link_libraries(fbi_ptscotch INTERFACE ${PTSCOTCH_LIBRARY})
endif()

add_library(fbi_suitesparse INTERFACE)
target_include_directories(fbi_suitesparse SYSTEM INTERFACE ${SUITESPARSE_INCLUDE})
target_link_libraries(fbi_suitesparse INTERFACE ${UMFPACK_LIBRARY} ${CHOLMOD_LIBRARY})
