#include "calibration/estimate/joint.h"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>
#include <fmt/format.h>

#include "calibration/estimate/joint_model.h"
#include "calibration/estimate/joint_robust.h"
#include "calibration/estimate/linear_fit.h"

namespace caltwin {
namespace {

constexpr double kHuber = 1.345;
constexpr double kHuberEfficiency = 0.95;
// Beliefs are relaxed by this to see what the readings know without them.
constexpr double kRelaxed = 1e3;
// An estimate that keeps more than this share of its prior's sd was not measured.
constexpr double kNotLearned = 0.9;

// One observation, as Ceres wants it.
class ReadingCost : public ceres::CostFunction {
 public:
  ReadingCost(const JointModel* model, std::size_t observation)
      : model_(model), observation_(observation) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(model->size()));
  }

  bool Evaluate(double const* const* u,
                double* residual,
                double** jacobian) const override {
    double* gradient = jacobian != nullptr ? jacobian[0] : nullptr;
    residual[0] = model_->Residual(observation_, u[0], gradient);
    return std::isfinite(residual[0]);
  }

 private:
  const JointModel* model_;
  std::size_t observation_;
};

// What is known of single unknowns, as rows (value - u) / sd in the unknowns' scale.
struct Knowledge {
  Eigen::MatrixXd rows{};
  Eigen::VectorXd targets{};
};

double ScaledSd(const JointModel::Unknown& unknown, const Given& given) {
  // An exact value is known to a millionth of its scale, which is a proper row.
  return std::max(given.sd / unknown.scale, 1e-6);
}

enum class Of { kBeliefs, kMeasured };

Knowledge KnowledgeOf(const JointModel& model, Of what, double relaxed) {
  Knowledge knowledge{.rows = Eigen::MatrixXd::Zero(model.size(), model.size()),
                      .targets = Eigen::VectorXd::Zero(model.size())};
  for (Eigen::Index i = 0; i < model.size(); ++i) {
    const JointModel::Unknown& unknown = model.unknowns()[static_cast<std::size_t>(i)];
    const Given& given = what == Of::kBeliefs ? unknown.prior : unknown.measured;
    if (!std::isfinite(given.sd)) continue;
    const double weight = 1 / (relaxed * ScaledSd(unknown, given));
    knowledge.rows(i, i) = weight;
    knowledge.targets[i] = weight * (given.value - unknown.start) / unknown.scale;
  }
  return knowledge;
}

// One row of Knowledge, as Ceres wants it.
class KnowledgeCost : public ceres::CostFunction {
 public:
  KnowledgeCost(Eigen::VectorXd row, double target)
      : row_(std::move(row)), target_(target) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(row_.size()));
  }

  bool Evaluate(double const* const* u,
                double* residual,
                double** jacobian) const override {
    residual[0] =
        row_.dot(Eigen::Map<const Eigen::VectorXd>(u[0], row_.size())) - target_;
    if (jacobian != nullptr && jacobian[0] != nullptr) {
      Eigen::Map<Eigen::VectorXd>(jacobian[0], row_.size()) = row_;
    }
    return true;
  }

 private:
  Eigen::VectorXd row_;
  double target_;
};

void AddKnowledge(const Knowledge& knowledge,
                  double* u,
                  ceres::Problem* ceres_problem) {
  for (Eigen::Index i = 0; i < knowledge.rows.rows(); ++i) {
    if (knowledge.rows(i, i) == 0) continue;
    ceres_problem->AddResidualBlock(
        new KnowledgeCost(knowledge.rows.row(i), knowledge.targets[i]), nullptr, u);
  }
}

// Solves for u; says whether it may be used, and Ceres' words.
bool Minimise(const JointModel& model,
              Loss loss,
              Eigen::VectorXd* u,
              std::string* words) {
  ceres::Problem ceres_problem;
  ceres_problem.AddParameterBlock(u->data(), static_cast<int>(model.size()));
  for (std::size_t i = 0; i < model.num_observations(); ++i) {
    ceres_problem.AddResidualBlock(
        new ReadingCost(&model, i),
        loss == Loss::kHuber ? new ceres::HuberLoss(kHuber) : nullptr,
        u->data());
  }
  for (const Of what : {Of::kBeliefs, Of::kMeasured}) {
    AddKnowledge(KnowledgeOf(model, what, 1), u->data(), &ceres_problem);
  }
  for (Eigen::Index i = 0; i < model.size(); ++i) {
    const JointModel::Unknown& unknown = model.unknowns()[static_cast<std::size_t>(i)];
    if (!std::isfinite(unknown.min)) continue;
    ceres_problem.SetParameterLowerBound(
        u->data(), static_cast<int>(i), (unknown.min - unknown.start) / unknown.scale);
  }

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-15;
  options.parameter_tolerance = 1e-13;
  options.gradient_tolerance = 1e-12;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  *words = summary.message;
  return summary.termination_type == ceres::CONVERGENCE;
}

// Rows below one another.
Eigen::MatrixXd Stacked(std::initializer_list<const Eigen::MatrixXd*> parts) {
  Eigen::Index rows = 0;
  for (const Eigen::MatrixXd* part : parts) rows += part->rows();
  Eigen::MatrixXd stacked(rows, (*parts.begin())->cols());
  rows = 0;
  for (const Eigen::MatrixXd* part : parts) {
    stacked.middleRows(rows, part->rows()) = *part;
    rows += part->rows();
  }
  return stacked;
}

// Covariance of u from whitened rows; directions that no row tells get the variance of
// a kilometre-wide guess rather than none.
Eigen::MatrixXd CovarianceOf(const Eigen::MatrixXd& rows) {
  constexpr double kWideGuess = 1e6;
  const Eigen::Index columns = rows.cols();
  const Eigen::MatrixXd guess =
      Eigen::MatrixXd::Identity(columns, columns) / kWideGuess;
  return SolveLinear(Stacked({&rows, &guess}),
                     Eigen::VectorXd::Zero(rows.rows() + columns),
                     {.relative = 0})
      .covariance;
}

// What one unit of u is worth in millimetres of a reading: its own scale where it is a
// length, else its largest effect on any of these readings.
double MmPerScale(const JointModel& model,
                  Eigen::Index i,
                  const Eigen::MatrixXd& jacobian) {
  const JointModel::Unknown& unknown = model.unknowns()[static_cast<std::size_t>(i)];
  if (unknown.unit == "mm") return unknown.scale;
  double largest_mm = 0;
  for (Eigen::Index row = 0; row < jacobian.rows(); ++row) {
    largest_mm = std::max(
        largest_mm,
        std::abs(jacobian(row, i)) * model.sigma_mm(static_cast<std::size_t>(row)));
  }
  return largest_mm > 0 ? largest_mm : 1;
}

ObservabilityReport ObserveModel(const JointModel& model,
                                 const Eigen::MatrixXd& jacobian) {
  std::vector<UnknownColumn> columns;
  for (Eigen::Index i = 0; i < model.size(); ++i) {
    columns.push_back({.name = model.unknowns()[static_cast<std::size_t>(i)].name,
                       .mm_per_unit = MmPerScale(model, i, jacobian)});
  }
  const Eigen::MatrixXd measured = KnowledgeOf(model, Of::kMeasured, 1).rows;
  return Observe(Stacked({&jacobian, &measured}), columns);
}

void AddEstimates(const JointModel& model,
                  const Eigen::VectorXd& u,
                  const Eigen::MatrixXd& covariance,
                  const Eigen::MatrixXd& without_beliefs,
                  JointFit* fit) {
  const Eigen::VectorXd values = model.Values(u);
  for (Eigen::Index i = 0; i < model.size(); ++i) {
    const JointModel::Unknown& unknown = model.unknowns()[static_cast<std::size_t>(i)];
    // Without a belief, a millimetre (one scale) is what "known" means.
    const double belief =
        std::isfinite(unknown.prior.sd) ? unknown.prior.sd : unknown.scale;
    const double alone_sd = std::sqrt(without_beliefs(i, i)) * unknown.scale;
    const double limit = kNotLearned * belief;
    fit->estimates.push_back({.name = unknown.name,
                              .unit = unknown.unit,
                              .value = values[i],
                              .sd = std::sqrt(covariance(i, i)) * unknown.scale,
                              .identifiable = fit->converged && alone_sd < limit,
                              .prior_sd = unknown.prior.sd,
                              .is_nuisance = unknown.is_nuisance});
  }
}

void AddCovariance(const JointModel& model,
                   const Eigen::MatrixXd& covariance,
                   JointFit* fit) {
  const Eigen::Index size = model.size();
  fit->covariance.resize(size, size);
  fit->correlation.resize(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      fit->covariance(i, j) = covariance(i, j) *
                              model.unknowns()[static_cast<std::size_t>(i)].scale *
                              model.unknowns()[static_cast<std::size_t>(j)].scale;
      fit->correlation(i, j) =
          covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
    }
  }
}

// Residuals, their size, and the degrees of freedom left over.
void AddResiduals(const JointModel& model,
                  const Eigen::VectorXd& residuals,
                  const Eigen::MatrixXd& jacobian,
                  const Eigen::MatrixXd& covariance,
                  JointFit* fit) {
  double squares_mm2 = 0;
  for (Eigen::Index row = 0; row < residuals.size(); ++row) {
    const double residual_mm =
        residuals[row] * model.sigma_mm(static_cast<std::size_t>(row));
    fit->residuals_mm.push_back(residual_mm);
    squares_mm2 += residual_mm * residual_mm;
  }
  const auto rows = static_cast<double>(residuals.size());
  if (rows > 0) fit->rms_mm = std::sqrt(squares_mm2 / rows);
  const double paid = (jacobian * covariance).cwiseProduct(jacobian).sum();
  fit->dof = rows - paid;
  if (fit->dof > 0.5) fit->chi2_per_dof = residuals.squaredNorm() / fit->dof;
}

// Adds what each row of knowledge, whitened, gives to unknown i: |C_ij w_j|, in its
// unit. Of what is below a thousandth of the variance, the root of the squares is
// returned.
double AddKnowledge(const JointModel& model,
                    const Eigen::MatrixXd& covariance,
                    Eigen::Index i,
                    std::vector<Contribution>* budget) {
  constexpr double kLittle = 1e-3;
  const Knowledge beliefs = KnowledgeOf(model, Of::kBeliefs, 1);
  const Knowledge measured = KnowledgeOf(model, Of::kMeasured, 1);
  const double scale = model.unknowns()[static_cast<std::size_t>(i)].scale;
  const double least = kLittle * covariance(i, i) * scale * scale;
  double little = 0;
  const auto add = [&](double weight, Eigen::Index j, const std::string& input) {
    const double u = std::abs(covariance(i, j) * weight) * scale;
    if (u * u >= least) {
      budget->push_back({.input = input, .u = u});
    } else {
      little = std::hypot(little, u);
    }
  };
  for (Eigen::Index j = 0; j < model.size(); ++j) {
    const std::string& name = model.unknowns()[static_cast<std::size_t>(j)].name;
    add(beliefs.rows(j, j), j, "prior of " + name);
    add(measured.rows(j, j), j, name + " as measured");
  }
  return little;
}

void AddBudgets(const JointModel& model,
                const Eigen::MatrixXd& covariance,
                const Eigen::MatrixXd& readings,
                JointFit* fit) {
  const Eigen::MatrixXd gain = readings * covariance;
  for (Eigen::Index i = 0; i < model.size(); ++i) {
    const double scale = model.unknowns()[static_cast<std::size_t>(i)].scale;
    std::vector<Contribution> budget{
        {.input = "readings", .u = gain.col(i).norm() * scale}};
    const double little = AddKnowledge(model, covariance, i, &budget);
    if (little > 0) budget.push_back({.input = "other priors", .u = little});
    fit->estimates[static_cast<std::size_t>(i)].budget = std::move(budget);
  }
}

double ObjectiveOf(const JointModel& model,
                   const Eigen::VectorXd& u,
                   const Eigen::VectorXd& residuals) {
  double objective = residuals.squaredNorm();
  for (const Of what : {Of::kBeliefs, Of::kMeasured}) {
    const Knowledge knowledge = KnowledgeOf(model, what, 1);
    objective += (knowledge.rows * u - knowledge.targets).squaredNorm();
  }
  return objective;
}

void WarnOfBounds(const JointModel& model, const Eigen::VectorXd& u, JointFit* fit) {
  const Eigen::VectorXd values = model.Values(u);
  for (Eigen::Index i = 0; i < model.size(); ++i) {
    const JointModel::Unknown& unknown = model.unknowns()[static_cast<std::size_t>(i)];
    if (values[i] > unknown.min + 1e-6 * unknown.scale) continue;
    fit->message += fmt::format(
        " {} ran into its lower bound of {} {}: the model does not suit these rows.",
        unknown.name,
        unknown.min,
        unknown.unit);
  }
}

}  // namespace

const JointEstimate* JointFit::Find(std::string_view name) const {
  const auto found = std::ranges::find(estimates, name, &JointEstimate::name);
  return found == estimates.end() ? nullptr : &*found;
}

JointFit FitJoint(const JointProblem& problem) {
  const JointModel model(problem);
  JointFit fit;
  if (model.size() == 0) {
    fit.message = "nothing to estimate";
    return fit;
  }
  Eigen::VectorXd u = Eigen::VectorXd::Zero(model.size());
  // Squares first: far from the solution Huber's loss has hardly any curvature.
  fit.converged = Minimise(model, Loss::kSquares, &u, &fit.message);
  if (problem.loss != Loss::kSquares) {
    fit.converged = Minimise(model, problem.loss, &u, &fit.message);
  }
  WarnOfBounds(model, u, &fit);

  Eigen::MatrixXd jacobian;
  const Eigen::VectorXd residuals = model.Residuals(u, &jacobian);
  fit.observability = ObserveModel(model, jacobian);
  fit.rank =
      static_cast<int>(model.size()) - static_cast<int>(fit.observability.blind.size());
  const double efficiency = problem.loss == Loss::kHuber ? kHuberEfficiency : 1;
  const Eigen::MatrixXd effective = jacobian * std::sqrt(efficiency);
  const Eigen::MatrixXd beliefs = KnowledgeOf(model, Of::kBeliefs, 1).rows;
  const Eigen::MatrixXd relaxed = KnowledgeOf(model, Of::kBeliefs, kRelaxed).rows;
  const Eigen::MatrixXd measured = KnowledgeOf(model, Of::kMeasured, 1).rows;
  const Eigen::MatrixXd covariance =
      CovarianceOf(Stacked({&effective, &beliefs, &measured}));
  const Eigen::MatrixXd without_beliefs =
      CovarianceOf(Stacked({&effective, &relaxed, &measured}));

  AddEstimates(model, u, covariance, without_beliefs, &fit);
  AddCovariance(model, covariance, &fit);
  AddResiduals(model, residuals, jacobian, covariance, &fit);
  AddBudgets(model, covariance, effective, &fit);
  fit.objective = ObjectiveOf(model, u, residuals);
  if (problem.with_robust) {
    AddRobust(model,
              problem,
              {.rows = jacobian,
               .residuals = residuals,
               .known = Stacked({&beliefs, &measured})},
              &fit);
  }
  return fit;
}

ObservabilityReport ObserveJoint(const JointProblem& problem) {
  const JointModel model(problem);
  Eigen::MatrixXd jacobian;
  model.Residuals(Eigen::VectorXd::Zero(model.size()), &jacobian);
  return ObserveModel(model, jacobian);
}

}  // namespace caltwin
