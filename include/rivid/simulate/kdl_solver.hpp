#pragma once

#include <cstddef>
#include <kdl/chain.hpp>
#include <kdl/chainidsolver.hpp>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"

namespace rivid {

/// KDL's inverse dynamics with identified parameters and friction, for controllers that take a
/// KDL::ChainIdSolver:
///
///   KDL::ChainIdSolver& solver = …;   // was ChainIdSolver_RNE
///   IdentifiedIdSolver solver(chain, read_identified_model("my_robot_result/result.json"));
///
/// τ = M q̈ + N + friction − Σ Jᵢᵀ f_ext,ᵢ. Geometry, gravity and inertias are those of the model; the
/// chain's are not looked at, but for the frames that external wrenches act in. After the constructor
/// CartToJnt() neither allocates nor throws.
class IdentifiedIdSolver final : public KDL::ChainIdSolver {
 public:
  /// @param chain  whose moving joints are those of the model, base to tip; it is copied
  /// @throws InputError  where the numbers of moving joints differ, a joint depends on others, or an option
  ///                     can not be used
  IdentifiedIdSolver(const KDL::Chain& chain, const ModelData& model,
                     const InverseDynamicsOptions& options = {})
      : chain_(chain),
        dynamics_(model, options),
        wrenches_(chain.getNrOfSegments()),
        poses_(chain.getNrOfSegments()),
        twists_(chain.getNrOfSegments()),
        q_(Vector::Zero(model.size())),
        qd_(q_),
        qdd_(q_),
        tau_(q_) {
    require_independent("IdentifiedIdSolver", model.chain);
    if (chain.getNrOfJoints() != static_cast<unsigned>(model.size())) {
      throw InputError("IdentifiedIdSolver: the chain has " + std::to_string(chain.getNrOfJoints()) +
                       " moving joints, the model " + std::to_string(model.size()));
    }
  }

  /// @param f_ext    wrench on each segment in its own frame, as ChainIdSolver_RNE takes it [N], [N·m]
  /// @param torques  (n) [N·m | N]
  /// @return         E_NOERROR, or E_SIZE_MISMATCH
  int CartToJnt(const KDL::JntArray& q, const KDL::JntArray& q_dot, const KDL::JntArray& q_dotdot,
                const KDL::Wrenches& f_ext, KDL::JntArray& torques) override {
    const auto n = static_cast<unsigned>(q_.size());
    if (q.rows() != n || q_dot.rows() != n || q_dotdot.rows() != n || torques.rows() != n ||
        f_ext.size() != wrenches_.size()) {
      return error = E_SIZE_MISMATCH;
    }
    for (unsigned j = 0; j < n; ++j) {
      q_[j] = q(j);
      qd_[j] = q_dot(j);
      qdd_[j] = q_dotdot(j);
    }
    dynamics_.torque(q_, qd_, qdd_, tau_);
    take_off(f_ext);
    for (unsigned j = 0; j < n; ++j) {
      torques(j) = tau_[j];
    }
    return error = E_NOERROR;
  }

  void updateInternalDataStructures() override {}

 private:
  void take_off(const KDL::Wrenches& f_ext) {
    Index j = 0;
    for (std::size_t i = 0; i < wrenches_.size(); ++i) {
      const KDL::Segment& segment = chain_.getSegment(static_cast<unsigned>(i));
      const bool fixed = segment.getJoint().getType() == KDL::Joint::Fixed;
      const double q = fixed ? 0.0 : q_[j++];
      poses_[i] = segment.pose(q);
      twists_[i] = poses_[i].M.Inverse(segment.twist(q, fixed ? 0.0 : 1.0));
      wrenches_[i] = f_ext[i];
    }
    for (std::size_t i = wrenches_.size(); i-- > 0;) {
      if (chain_.getSegment(static_cast<unsigned>(i)).getJoint().getType() != KDL::Joint::Fixed) {
        tau_[--j] -= KDL::dot(twists_[i], wrenches_[i]);
      }
      if (i > 0) {
        wrenches_[i - 1] = wrenches_[i - 1] + poses_[i] * wrenches_[i];
      }
    }
  }

  KDL::Chain chain_;
  InverseDynamics dynamics_;
  KDL::Wrenches wrenches_;
  std::vector<KDL::Frame> poses_;
  std::vector<KDL::Twist> twists_;
  Vector q_, qd_, qdd_, tau_;
};

}  // namespace rivid
