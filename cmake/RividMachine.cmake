# Refuses what rivid does not run on before a compiler says so in other words: a log has more bytes than 32
# bits address, and what is read and written byte by byte (packed numbers of pages, NumPy files, the reader of
# numbers) is little-endian. Neither kind of machine was ever tested.

if(CMAKE_SIZEOF_VOID_P AND NOT CMAKE_SIZEOF_VOID_P EQUAL 8)
  math(EXPR bits "8 * ${CMAKE_SIZEOF_VOID_P}")
  message(FATAL_ERROR "rivid needs a machine of 64 bits; ${CMAKE_CXX_COMPILER} compiles for one of ${bits}. "
                      "Choose a compiler for 64 bits (CMAKE_CXX_COMPILER, without -m32).")
endif()
if(CMAKE_CXX_BYTE_ORDER STREQUAL "BIG_ENDIAN")
  message(FATAL_ERROR "rivid needs a little-endian machine; ${CMAKE_CXX_COMPILER} compiles for a big-endian one. "
                      "Choose a compiler for a little-endian one (CMAKE_CXX_COMPILER).")
endif()
