# Flags for our own targets alone: warnings, sanitizers, clang-tidy. Nothing here reaches a user of rivid.

option(RIVID_WARNINGS_AS_ERRORS "Treat compiler warnings as errors" OFF)
option(RIVID_SANITIZE "Build with AddressSanitizer and UndefinedBehaviorSanitizer" OFF)
option(RIVID_CORE_ONLY "Build the rooms of the library that know of no experiment, for the preset core-sanitize" OFF)
set(RIVID_CORE model signal data solve regressor simulate)
option(RIVID_SANITIZE_THREADS "Build with ThreadSanitizer" OFF)
option(RIVID_FUZZ "Build the harnesses of tests/fuzz with libFuzzer, which clang has" OFF)
option(RIVID_HARDEN "Build library, tools and Python extension with stack protector, FORTIFY and BIND_NOW" ON)
option(RIVID_TIDY "Run clang-tidy on the library and the apps" OFF)

function(rivid_developer_flags target)
  target_compile_options(
    ${target}
    PRIVATE -Wall
            -Wextra
            -Wpedantic
            # Files that are compiled as one see each other's unnamed namespaces.
            $<$<NOT:$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>>:-Wshadow>
            -Wconversion
            -Wsign-conversion
            -Wold-style-cast
            -Wnon-virtual-dtor
            -Wdouble-promotion
            # GCC 12 takes "text" + std::string for an overlapping copy (its bug 105329).
            $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
            # GCC 14 takes the copy of a vector with one element for one of more.
            "$<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,14>>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>"
            $<$<BOOL:${RIVID_WARNINGS_AS_ERRORS}>:-Werror>)
  if(RIVID_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=address,undefined -fno-sanitize-recover=all
                                             -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=address,undefined)
    if(RIVID_CORE_ONLY)
      # Checks of each pointer take as long to compile as all the others.
      target_compile_options(${target} PRIVATE -fno-sanitize=null,alignment,vptr,object-size,pointer-overflow)
    endif()
  endif()
  if(RIVID_SANITIZE_THREADS)
    target_compile_options(${target} PRIVATE -fsanitize=thread)
    target_link_options(${target} PRIVATE -fsanitize=thread)
  endif()
  if(RIVID_FUZZ)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
endfunction()

# The library, which has the parsers, and what is linked with it. A sanitizer has checks of its own.
function(rivid_hardened target)
  if(RIVID_HARDEN AND NOT RIVID_SANITIZE AND NOT RIVID_SANITIZE_THREADS)
    target_compile_options(${target} PRIVATE -fstack-protector-strong
                                             $<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2>)
    target_link_options(${target} PRIVATE LINKER:-z,relro,-z,now)
  endif()
endfunction()

# clang-tidy costs minutes, so it looks at src/ and apps/ only, and only when asked.
function(rivid_tidy target)
  if(RIVID_TIDY)
    find_program(RIVID_CLANG_TIDY NAMES clang-tidy-19 clang-tidy REQUIRED)
    set_target_properties(${target} PROPERTIES CXX_CLANG_TIDY "${RIVID_CLANG_TIDY}")
  endif()
endfunction()

# A SUNDIALS that was built with MPI gets the names that it asks for, so that no libmpi is loaded: see
# src/without_mpi.cpp.
function(rivid_without_mpi target)
  if(RIVID_SUNDIALS_7)
    target_sources(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src/without_mpi.cpp)
    target_link_options(${target} PRIVATE LINKER:--as-needed)
  endif()
endfunction()
