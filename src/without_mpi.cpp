// SUNDIALS 7 of Debian is built with MPI. Its profiler and its log refer to MPI, and a program of one process
// calls nothing of that: with these names in tools and shared library no libmpi is loaded. Not in the
// archive, whose users may have MPI.

#include <cstdlib>

extern "C" {
#pragma GCC visibility push(hidden)

// The names of Open MPI for "no communicator" and for types. Their addresses alone are looked at.
char ompi_mpi_comm_null = 0;
char ompi_mpi_double = 0;
char ompi_mpi_long = 0;

[[noreturn]] void MPI_Abort() { std::abort(); }
[[noreturn]] void MPI_Comm_dup() { std::abort(); }
[[noreturn]] void MPI_Comm_free() { std::abort(); }
[[noreturn]] void MPI_Comm_rank() { std::abort(); }
[[noreturn]] void MPI_Comm_size() { std::abort(); }
[[noreturn]] void MPI_Op_create() { std::abort(); }
[[noreturn]] void MPI_Op_free() { std::abort(); }
[[noreturn]] void MPI_Reduce() { std::abort(); }
[[noreturn]] void MPI_Type_commit() { std::abort(); }
[[noreturn]] void MPI_Type_create_resized() { std::abort(); }
[[noreturn]] void MPI_Type_create_struct() { std::abort(); }
[[noreturn]] void MPI_Type_free() { std::abort(); }
[[noreturn]] void MPI_Type_get_extent() { std::abort(); }

#pragma GCC visibility pop
}
