#include "scenarios/study/store.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include "sim/base/input_error.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFormat = "2";
constexpr const char* kState = "state";

// Of SQLite's log, which grows to 1000 pages; of `study.sqlite` and `trials.csv`, a run
// with a dozen parameters.
constexpr double kFixed_bytes = 5e6, kBytesPerRun = 2000;

// `results` has a row only for what a run reported; NULL is "not told".
constexpr const char* kSchema = R"(
CREATE TABLE IF NOT EXISTS study(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS cases(
  case_id INTEGER PRIMARY KEY, name TEXT NOT NULL, scenario TEXT NOT NULL,
  procedure TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS parameters(
  parameter_id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, unit TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS trials(
  trial INTEGER NOT NULL, case_id INTEGER NOT NULL, status TEXT NOT NULL,
  machine_time_s REAL NOT NULL, touches INTEGER NOT NULL,
  position_error_before_mm REAL, position_error_after_mm REAL, message TEXT NOT NULL,
  PRIMARY KEY(trial, case_id)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS results(
  trial INTEGER NOT NULL, case_id INTEGER NOT NULL, parameter_id INTEGER NOT NULL,
  position INTEGER NOT NULL, injected REAL NOT NULL, recovered REAL, sd REAL,
  is_setting INTEGER NOT NULL, u REAL, dof REAL,
  PRIMARY KEY(trial, case_id, parameter_id)) WITHOUT ROWID;
)";

void BindOptional(SQLite::Statement* statement, int at, std::optional<double> value) {
  if (value) {
    statement->bind(at, *value);
  } else {
    statement->bind(at);
  }
}

// What sd is made of, u and its degrees of freedom; NULL of these: infinite.
void BindCombined(SQLite::Statement* result, const ParameterResult& parameter) {
  const auto combined = CombinedOf(parameter);
  BindOptional(result, 9, combined ? std::optional(combined->u) : std::nullopt);
  const bool is_few = combined && std::isfinite(combined->dof);
  BindOptional(result, 10, is_few ? std::optional(combined->dof) : std::nullopt);
}

std::optional<double> OptionalOf(const SQLite::Column& column) {
  if (column.isNull()) return std::nullopt;
  return column.getDouble();
}

ParameterResult ParameterAt(SQLite::Statement& results) {
  ParameterResult parameter{.name = results.getColumn(0).getString(),
                            .unit = results.getColumn(1).getString(),
                            .injected = results.getColumn(2).getDouble(),
                            .recovered = OptionalOf(results.getColumn(3)),
                            .sd = OptionalOf(results.getColumn(4)),
                            .is_setting = results.getColumn(5).getInt() != 0};
  if (const auto u = OptionalOf(results.getColumn(6))) {
    Contribution all{.input = "all inputs", .u = *u};
    if (const auto dof = OptionalOf(results.getColumn(7))) all.dof = *dof;
    parameter.budget = {all};
  }
  parameter.identifiable = parameter.recovered.has_value();
  if (parameter.recovered) parameter.error = *parameter.recovered - parameter.injected;
  return parameter;
}

// One message, whatever SQLite says.
[[noreturn]] void Fail(const fs::path& file, const SQLite::Exception& error) {
  const bool is_full = error.getErrorCode() == SQLITE_FULL;
  throw InputError(
      {.file = file.string()},
      is_full ? "the disk is full; what was done until now is kept"
              : fmt::format("cannot be written or read: {}", error.what()),
      is_full ? "make room, then `--resume`" : "choose another folder with --out");
}

// Does it; what SQLite throws becomes the person's message.
template <typename Act>
auto OrFail(const fs::path& file, const Act& act) {
  try {
    return act();
  } catch (const SQLite::Exception& failed) {
    Fail(file, failed);
  }
}

// Runs whose trials will lie in the file at a time.
double MostRuns(const Study& study, const Shard& shard) {
  const double runs = static_cast<double>(study.most_trials) *
                      static_cast<double>(study.cases.size()) /
                      static_cast<double>(shard.count);
  return study.keeps_trials ? runs : std::min(runs, 1.0 * StudyStore::kMostUnfolded);
}

// There, in a folder where nothing can be written: SQLite's log neither.
bool IsFixed(const fs::path& file) {
  std::error_code error;
  return fs::exists(file, error) && access(file.parent_path().c_str(), W_OK) != 0;
}

std::string FixedUri(const fs::path& file) {
  std::string uri = "file:";
  for (const char c : fs::absolute(file).string()) {
    const bool is_special = c == '%' || c == '?' || c == '#';
    uri += is_special ? fmt::format("%{:02X}", c) : std::string(1, c);
  }
  return uri + "?immutable=1";
}

}  // namespace

struct StudyStore::Parts {
  explicit Parts(const fs::path& file)
      : db(IsFixed(file) ? FixedUri(file) : file.string(),
           IsFixed(file) ? SQLite::OPEN_READONLY | SQLite::OPEN_URI
                         : SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE) {
    if (IsFixed(file)) return;
    db.setBusyTimeout(10'000);
    // A commit is a write to the log: a killed process loses none of them.
    db.exec("PRAGMA journal_mode = WAL");
    db.exec("PRAGMA synchronous = NORMAL");
    db.exec(kSchema);
  }

  std::optional<std::string> Kept(const std::string& key) {
    SQLite::Statement query(db, "SELECT value FROM study WHERE key = ?");
    query.bind(1, key);
    if (!query.executeStep()) return std::nullopt;
    return query.getColumn(0).getString();
  }

  bool HoldsTrials() {
    return Kept(kState) ||
           db.execAndGet("SELECT EXISTS(SELECT 1 FROM trials)").getInt() != 0;
  }

  void Fold(const std::string& state) {
    SQLite::Transaction transaction(db);
    SQLite::Statement keep(db, "REPLACE INTO study VALUES(?, ?)");
    keep.bind(1, kState);
    keep.bind(2, state);
    keep.exec();
    db.exec("DELETE FROM results");
    db.exec("DELETE FROM trials");
    transaction.commit();
  }

  void Begin(const Study& study, const Shard& shard) {
    SQLite::Transaction transaction(db);
    SQLite::Statement keep(db, "INSERT INTO study VALUES(?, ?)");
    for (const auto& [key, value] :
         {std::pair<std::string, std::string>{"format", kFormat},
          {"fingerprint", study.Fingerprint()},
          {"version", CALTWIN_VERSION},
          {"file", study.file.string()},
          {"text", study.verbatim},
          {"fidelity", study.FidelityWord()},
          {"seed", std::to_string(study.seed)},
          {"trials", std::to_string(study.trials)},
          {"shard", shard.Text()}}) {
      keep.bind(1, key);
      keep.bind(2, value);
      keep.exec();
      keep.reset();
    }
    SQLite::Statement name(db, "INSERT INTO cases VALUES(?, ?, ?, ?)");
    for (std::size_t i = 0; i < study.cases.size(); ++i) {
      name.bind(1, static_cast<std::int64_t>(i));
      name.bind(2, study.cases[i].Name());
      name.bind(3, study.cases[i].scenario.file.string());
      name.bind(4, study.cases[i].procedure);
      name.exec();
      name.reset();
    }
    transaction.commit();
  }

  std::int64_t ParameterId(const ParameterResult& parameter) {
    const auto known = parameter_ids.find(parameter.name);
    if (known != parameter_ids.end()) return known->second;
    SQLite::Statement add(db,
                          "INSERT OR IGNORE INTO parameters(name, unit) VALUES(?, ?)");
    add.bind(1, parameter.name);
    add.bind(2, parameter.unit);
    add.exec();
    SQLite::Statement find(db, "SELECT parameter_id FROM parameters WHERE name = ?");
    find.bind(1, parameter.name);
    find.executeStep();
    return parameter_ids[parameter.name] = find.getColumn(0).getInt64();
  }

  void Add(const TrialResult& result) {
    SQLite::Transaction transaction(db);
    SQLite::Statement& t = *add_trial;
    t.bind(1, result.trial);
    t.bind(2, static_cast<std::int64_t>(result.of_case));
    t.bind(3, result.status);
    t.bind(4, result.machine_time_s);
    t.bind(5, result.touches);
    t.bind(6, result.position_error_before_mm);
    t.bind(7, result.position_error_after_mm);
    t.bind(8, result.message);
    t.exec();
    t.reset();
    SQLite::Statement& r = *add_result;
    for (std::size_t i = 0; i < result.parameters.size(); ++i) {
      const ParameterResult& parameter = result.parameters[i];
      r.bind(1, result.trial);
      r.bind(2, static_cast<std::int64_t>(result.of_case));
      r.bind(3, ParameterId(parameter));
      r.bind(4, static_cast<std::int64_t>(i));
      r.bind(5, parameter.injected);
      BindOptional(&r, 6, parameter.recovered);
      BindOptional(&r, 7, parameter.sd);
      r.bind(8, parameter.is_setting ? 1 : 0);
      BindCombined(&r, parameter);
      r.exec();
      r.reset();
    }
    transaction.commit();
  }

  void ForEach(const std::function<void(const TrialResult&)>& look,
               std::int64_t first,
               std::int64_t last) {
    SQLite::Statement trials(db,
                             "SELECT * FROM trials WHERE trial >= ? AND trial < ? "
                             "ORDER BY trial, case_id");
    trials.bind(1, first);
    trials.bind(2, last);
    SQLite::Statement results(
        db,
        "SELECT name, unit, injected, recovered, sd, is_setting, u, dof FROM results "
        "JOIN parameters USING(parameter_id) WHERE trial = ? AND case_id = ? "
        "ORDER BY position");
    while (trials.executeStep()) {
      TrialResult result{
          .trial = trials.getColumn(0).getInt64(),
          .of_case = static_cast<std::size_t>(trials.getColumn(1).getInt64()),
          .status = trials.getColumn(2).getString(),
          .machine_time_s = trials.getColumn(3).getDouble(),
          .touches = trials.getColumn(4).getInt(),
          .position_error_before_mm = trials.getColumn(5).getDouble(),
          .position_error_after_mm = trials.getColumn(6).getDouble(),
          .message = trials.getColumn(7).getString()};
      results.bind(1, result.trial);
      results.bind(2, static_cast<std::int64_t>(result.of_case));
      while (results.executeStep()) result.parameters.push_back(ParameterAt(results));
      results.reset();
      look(result);
    }
  }

  SQLite::Database db;
  std::map<std::string, std::int64_t> parameter_ids{};
  std::optional<SQLite::Statement> add_trial{}, add_result{};
};

StudyStore::StudyStore(const fs::path& folder,
                       const Study& study,
                       bool may_resume,
                       const Shard& shard)
    : file_(folder / (study.keeps_trials ? "study.sqlite" : kUnfinished)) {
  std::error_code error;
  // A killed program's log is still to be taken over, which is writing.
  const bool has_log = fs::exists(file_.string() + "-wal", error);
  has_made_folder_ = MakeWritable(folder, fs::exists(file_, error) && !has_log);
  lock_ = FolderLock(folder);
  is_new_ = !fs::exists(file_, error);
  if (is_new_) {
    const double runs = MostRuns(study, shard);
    RequireRoom(folder, runs, kFixed_bytes + kBytesPerRun * runs, has_made_folder_);
  }
  OrFail(file_, [&] {
    parts_ = std::make_unique<Parts>(file_);
    const bool is_new = !parts_->Kept("fingerprint");
    if (!is_new) RequireSameStudy(study);
    const std::string part = parts_->Kept("shard").value_or(shard.Text());
    if (part != shard.Text()) {
      throw InputError(
          {.file = file_.string()},
          fmt::format("holds part {} of the study, not {}", part, shard.Text()),
          "choose another folder with --out");
    }
    if (parts_->HoldsTrials() && !may_resume) {
      throw InputError({.file = file_.string()},
                       "holds trials of this study already",
                       "`--resume` goes on with them; --out begins elsewhere");
    }
    if (is_new) parts_->Begin(study, shard);
    parts_->add_trial.emplace(parts_->db,
                              "INSERT INTO trials VALUES(?, ?, ?, ?, ?, ?, ?, ?)");
    parts_->add_result.emplace(
        parts_->db, "INSERT INTO results VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  });
}

StudyStore::StudyStore(fs::path file) : file_(std::move(file)) {}
StudyStore::~StudyStore() = default;

void StudyStore::DiscardIfEmpty() {
  if (!is_new_ || OrFail(file_, [&] { return parts_->HoldsTrials(); })) return;
  Discard();
  std::error_code error;
  if (has_made_folder_) fs::remove(file_.parent_path(), error);
}

void StudyStore::Discard() {
  parts_.reset();
  std::error_code error;
  for (const char* ending : {"", "-wal", "-shm"}) {
    fs::remove(file_.string() + ending, error);
  }
}

std::unique_ptr<StudyStore> StudyStore::OpenPart(const fs::path& folder,
                                                 const Study& study) {
  std::unique_ptr<StudyStore> part(new StudyStore(folder / "study.sqlite"));
  std::error_code error;
  if (!fs::is_regular_file(part->file_, error)) {
    throw InputError({.file = part->file_.string()},
                     "is not there",
                     "name the --out folders of the study's parts");
  }
  OrFail(part->file_, [&] {
    part->parts_ = std::make_unique<Parts>(part->file_);
    part->RequireSameStudy(study);
  });
  return part;
}

std::string StudyStore::ShardText() const {
  return parts_->Kept("shard").value_or(Shard{}.Text());
}

void StudyStore::RequireSameStudy(const Study& study) const {
  const bool is_same = parts_->Kept("fingerprint") == study.Fingerprint();
  if (is_same && parts_->Kept("format") == kFormat) return;
  throw InputError({.file = file_.string()},
                   "holds another study, or this one before its files or the program "
                   "changed",
                   "choose another folder with --out");
}

void StudyStore::Add(const TrialResult& result) {
  OrFail(file_, [&] { parts_->Add(result); });
}

void StudyStore::Fold(const std::string& state) {
  OrFail(file_, [&] { parts_->Fold(state); });
}

std::optional<std::string> StudyStore::Folded() const {
  return OrFail(file_, [&] { return parts_->Kept(kState); });
}

std::set<std::pair<std::int64_t, std::size_t>> StudyStore::Done() const {
  return OrFail(file_, [&] {
    std::set<std::pair<std::int64_t, std::size_t>> done;
    SQLite::Statement query(parts_->db, "SELECT trial, case_id FROM trials");
    while (query.executeStep()) {
      done.emplace(query.getColumn(0).getInt64(),
                   static_cast<std::size_t>(query.getColumn(1).getInt64()));
    }
    return done;
  });
}

void StudyStore::ForEach(const std::function<void(const TrialResult&)>& look,
                         std::int64_t first,
                         std::int64_t last) const {
  OrFail(file_, [&] { parts_->ForEach(look, first, last); });
}

}  // namespace caltwin
