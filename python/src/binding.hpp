#pragma once

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <string_view>

#include "rivid/identify/estimation.hpp"

// What the files of the extension share. Options come as TOML text in the words of experiment files and results go as the JSON
// documents that the tools write: neither is described here again.
namespace rivid::python {

namespace nb = nanobind;
using namespace nb::literals;

/// Lets other threads of Python run.
using Unlocked = nb::call_guard<nb::gil_scoped_release>;

/// Where long work calls Python now and then: an interrupt ends it, and a callback hears how far it is. The callback must
/// outlive the work, which holds no lock of Python meanwhile.
class Listener {
 public:
  explicit Listener(const nb::object& callback) : callback_(&callback) {}

  void operator()(std::string_view stage, double fraction) const {
    const nb::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) {
      throw nb::python_error();
    }
    if (!callback_->is_none()) {
      (*callback_)(nb::str(stage.data(), stage.size()), fraction);
    }
  }

 private:
  const nb::object* callback_;
};

/// A matrix of an object as an array that reads its memory.
inline Eigen::Map<const Matrix> view(const Matrix& m) { return {m.data(), m.rows(), m.cols()}; }
inline Eigen::Map<const Vector> view(const Vector& v) { return {v.data(), v.size()}; }

/// A read-only array of a member, which keeps its object alive.
template <typename Class, typename Member>
void def_array(Class& type, const char* name, Member member, const char* text) {
  using Owner = typename Class::Type;
  type.def_prop_ro(
      name, [member](const Owner& self) { return view(self.*member); }, nb::rv_policy::reference_internal,
      text);
}

void bind_data(nb::module_& m);
void bind_identify(nb::module_& m);
void bind_factors(nb::module_& m);
void bind_dynamics(nb::module_& m);
void bind_experiment(nb::module_& m);
void bind_online(nb::module_& m);
void bind_payload(nb::module_& m);

}  // namespace rivid::python
