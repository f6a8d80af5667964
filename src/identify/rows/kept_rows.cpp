#include "identify/rows/kept_rows.hpp"

#include <algorithm>
#include <cassert>

namespace rivid::detail {

namespace {

// Rows `first` … `first` + `count` − 1 of a matrix into the columns of a room from column `column` on.
void copy_rows(const Eigen::Ref<const Matrix>& rows, Index first, Index count, const RowsTarget& target,
               Index column) {
  for (Index c = 0; c < rows.cols(); ++c) {
    std::copy_n(rows.col(c).data() + first, count, target.data + (column + c) * target.ld);
  }
}

// Takes rows [V W Y] of a joint, holds [W Y] and hands all on.
class KeepingSink final : public RowSink {
 public:
  // others  columns of V
  KeepingSink(RowSink& to, HeldRows& kept, Index others) : to_(to), kept_(kept), others_(others) {}

  RowsRoom room(Index wanted) override { return room_ = to_.room(wanted); }
  void commit(std::span<const Index> samples) override {
    const auto count = static_cast<Index>(samples.size());
    const RowsTarget to = kept_.room(count).target;
    const RowsTarget& from = room_.target;
    for (Index c = 0; c < kept_.columns(); ++c) {
      std::copy_n(from.data + (others_ + c) * from.ld, count, to.data + c * to.ld);
    }
    kept_.commit(samples);
    to_.commit(samples);
  }

 private:
  RowSink& to_;
  HeldRows& kept_;
  Index others_;
  RowsRoom room_{};
};

// Takes rows V of a joint and hands [V W Y] on.
class JoiningSink final : public RowSink {
 public:
  JoiningSink(RowSink& to, const HeldRows& kept, Index others) : to_(to), kept_(kept), others_(others) {}

  RowsRoom room(Index wanted) override { return room_ = to_.room(wanted); }
  void commit(std::span<const Index> samples) override {
    const auto count = static_cast<Index>(samples.size());
    assert(std::ranges::equal(
        samples, std::span(kept_.samples()).subspan(static_cast<std::size_t>(next_), samples.size())));
    copy_rows(kept_.rows(), next_, count, room_.target, others_);
    next_ += count;
    to_.commit(samples);
  }

 private:
  RowSink& to_;
  const HeldRows& kept_;
  Index others_;
  Index next_ = 0;
  RowsRoom room_{};
};

}  // namespace

bool KeptRows::worthwhile(const SignalOptions& signal) { return stride_of(signal) > 1; }

std::size_t KeptRows::bytes() const {
  Index numbers = source_.numbers();
  for (std::size_t j = 0; j < source_.joints(); ++j) {
    numbers += source_.rows() * (static_cast<Index>(source_.columns(j).size()) + 1);
  }
  return static_cast<std::size_t>(numbers) * sizeof(double);
}

void KeptRows::send(std::span<RowSink* const> sinks, std::span<const Motion> others,
                    const std::function<void(double)>& progress) {
  if (!rows_.empty() && others.empty()) {
    send_kept(sinks);
    return;
  }
  const auto columns_of_others = [&](std::size_t j) {
    return static_cast<Index>(source_.columns(j).size() * others.size());
  };
  if (!rows_.empty()) {
    const JointSinks<JoiningSink> joining(source_.joints(), [&](std::size_t j) {
      return JoiningSink(*sinks[j], rows_[j], columns_of_others(j));
    });
    source_.send_others(joining.sinks(), others);
    return;
  }
  std::vector<HeldRows> rows = made_of(source_.joints(), [&](std::size_t j) {
    return HeldRows(source_.rows(), std::ssize(source_.columns(j)) + 1);
  });
  const JointSinks<KeepingSink> keeping(
      source_.joints(), [&](std::size_t j) { return KeepingSink(*sinks[j], rows[j], columns_of_others(j)); });
  source_.send(keeping.sinks(), others, progress);
  rows_ = std::move(rows);
}

void KeptRows::send_kept(std::span<RowSink* const> sinks) const {
  for (std::size_t j = 0; j < rows_.size(); ++j) {
    const std::span<const Index> samples = rows_[j].samples();
    for (Index first = 0, count = 0; first < rows_[j].size(); first += count) {
      count = std::min(RowSource::most_wanted, rows_[j].size() - first);
      const RowsRoom room = sinks[j]->room(count);
      copy_rows(rows_[j].rows(), first, count, room.target, 0);
      sinks[j]->commit(samples.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count)));
    }
  }
}

}  // namespace rivid::detail
