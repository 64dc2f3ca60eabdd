// The options of every command that runs a session: demo and record.
#pragma once

#include "app/commands/command.h"
#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "engine/session/session_options.h"

#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// `--model` and what overrides it, part by part.
struct ModelTyped {
    std::string use = "full";
    std::string plant;
    std::optional<double> step_us;
    std::string surface;

    void add_to(Command &command);

    /// @throw InputError for an unknown part.
    [[nodiscard]] session::ModelOptions options(const TuningOptions &tuning) const;
};

/// The options hold references to this: it must stay where it is until the parse is over.
struct TypedSession {
    session::SessionOptions options;
    TuningOptions tuning;
    EffectOptions effects;
    ModelTyped model;
    TypedEmulation emulation;
    std::optional<double> delay_periods;
    std::string device = "sim";
    std::optional<double> late_limit_ms;

    void add_to(Command &command);

    /// The options of the session.
    /// @throw InputError for options with which no session can run.
    [[nodiscard]] session::SessionOptions session() const;

    /// What it reads and writes.
    /// @param written  beside the record
    [[nodiscard]] RunFiles files(std::vector<std::filesystem::path> written) const;

private:
    void set_device(session::SessionOptions &session) const;
};

} // namespace springdrive::app
