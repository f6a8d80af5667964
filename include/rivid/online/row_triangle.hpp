#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "rivid/online/information_triangle.hpp"
#include "rivid/online/load_tangent.hpp"
#include "rivid/online/row_stream.hpp"

namespace rivid::detail {

// The rows of a control loop on their way into the triangle of an estimate, and the time that goes by meanwhile: what the estimators
// have in common. `report` is what they do with the Outcome of a row.
template <typename Scalar>
class RowTriangle {
 public:
  using Stream = RowStream<Scalar>;
  using Triangle = InformationTriangle<Scalar>;
  using Values = typename Stream::Values;

  // columns     of the rows: the model's base parameters, and more behind them
  // unknowns    of the triangle
  // forgetting  time constant of the information [s]
  // others      rows that come in each stride beside those of the joints
  // kept        first entries of a row that its Outcome shows as they were
  RowTriangle(const OnlineModel& model, std::span<const StandardParameter> columns,
              const RowStreamOptions& options, Index unknowns, double forgetting, Index others = 0,
              Index kept = 0)
      : stream_(model.robot, columns, options),
        load_(model, stream_.columns(), columns),
        triangle_(unknowns, 2 * model.robot.size() + others, kept),
        seconds_(static_cast<double>(stream_.stride()) / options.f_m),
        keep_(std::exp(-0.5 * seconds_ / forgetting)),
        operations_((model.robot.size() + others) * triangle_.cost_of_row() / stream_.stride() + unknowns) {}

  [[nodiscard]] const Stream& stream() const noexcept { return stream_; }
  [[nodiscard]] Triangle& triangle() noexcept { return triangle_; }
  [[nodiscard]] const Triangle& triangle() const noexcept { return triangle_; }
  // Time of a stride [s], and what is left of R after it.
  [[nodiscard]] double seconds() const noexcept { return seconds_; }
  [[nodiscard]] double keep() const noexcept { return keep_; }
  // Factor of n rows of what is known beforehand, one of which comes back in each stride, so that they fade as little as they are repeated.
  [[nodiscard]] double repeated(Index n) const noexcept {
    return std::sqrt(static_cast<double>(n) * (1.0 - keep_ * keep_));
  }

  // A body on the last link that the model does not have, whose load friction feels: XX … M, and the columns of these.
  template <typename Body, typename Places>
  void set_body(const Body& body, const Places& places) noexcept {
    load_.set_body(body, places);
  }

  // A tick: add(Row) for each row that it finishes, step() once a stride while any joint moves, then as much work on the rows that wait
  // as each tick has. (Joints finish their rows at ticks of their own.)
  template <typename Add, typename Step, typename Report>
  void tick(const Values& q, const Values& tau, const Add& add, const Step& step,
            const Report& report) noexcept {
    if (stream_.update(q, tau)) {
      stream_.for_each_row([&](const typename Stream::Row& row) { add(load_(row)); });
      if (until_step_ == 0) {
        until_step_ = stream_.stride();
        step();
      }
    }
    until_step_ = std::max<Index>(until_step_ - 1, 0);
    static_cast<void>(triangle_.work(operations_, report));
  }

  // Room for a row, full of zeros, at once: rows that wait are taken first where there is none.
  template <typename Report>
  [[nodiscard]] Scalar* room(const Report& report) noexcept {
    while (triangle_.full()) {
      static_cast<void>(triangle_.work(triangle_.cost_of_row(), report));
    }
    return triangle_.room();
  }

  // Windows begin anew.
  void reset_stream() noexcept { stream_.reset(); }

  template <typename Visit>
  void visit_state(Visit& visit) noexcept {
    auto& [stream, load, triangle, seconds, keep, operations, until_step] = *this;
    visit_parts(visit, stream, load, triangle, until_step);
  }

 private:
  Stream stream_;
  LoadTangent<Scalar> load_;
  Triangle triangle_;
  double seconds_;
  double keep_;
  Index operations_;  // of each tick
  Index until_step_ = 0;
};

}  // namespace rivid::detail
