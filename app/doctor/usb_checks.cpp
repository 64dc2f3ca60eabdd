// What stands between springdrive and a board on USB.
#include "app/doctor/checks.h"

#include "app/doctor/usb_boards.h"
#include "device/usb/protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace springdrive::app::doctor {

namespace {

using usb::BoardObstacle;

constexpr double kFullSpeedMost_hz = 1000.0;

constexpr const char *kMattersUsb = "springdrive --device usb drives it";

constexpr const char *kContainerLine = "start the container with -v /dev/bus/usb:/dev/bus/usb "
                                       "--device-cgroup-rule 'c 189:* rmw'";

Check absent(const Evidence &evidence) {
    const Machine &machine = evidence.machine;
    Check check{"usb_board", "board on USB", Verdict::not_applicable, "", kMattersUsb, ""};
    const std::string &problem = evidence.trials.usb.problem;
    check.found =
        fmt::format("none is connected (vendor {:04x}, product {:04x}, interface {:02x}/{:02x}){}",
                    usb::kVendorId, usb::kProductId, usb::kInterfaceClass, usb::kInterfaceSubclass,
                    problem.empty() ? "" : "; " + problem);
    for (const std::string &name : others_with_its_numbers(machine)) {
        check.found +=
            fmt::format("; {} has these numbers, but not the interface: another product, "
                        "or a board without its firmware",
                        name);
    }
    if (!evidence.purpose.uses_usb) {
        check.found += "; not needed by --device sim";
        return check;
    }
    check.verdict = Verdict::failure;
    check.mend = machine.exists("/dev/bus/usb") ? "plug the board in and switch its power on, then "
                                                  "see: springdrive device list"
                 : machine.is_container()       ? kContainerLine
                                                : "use a computer that has USB: this one has no "
                                                  "/dev/bus/usb";
    return check;
}

std::string list_of(const std::vector<Board> &boards) {
    std::string list;
    for (const Board &board : boards) {
        list += (list.empty() ? "" : ", ") + board.name();
    }
    return list;
}

Check presence(const Evidence &evidence, const std::vector<Board> &all,
               const std::vector<Board> &meant) {
    const Purpose &purpose = evidence.purpose;
    Check check{"usb_board", "board on USB", Verdict::ok, list_of(all), kMattersUsb, ""};
    if (meant.empty()) {
        check.verdict = Verdict::failure;
        check.found = fmt::format("none has the serial number {}, but {} is there", purpose.serial,
                                  list_of(all));
        check.mend = "springdrive --device usb:" + shell_word(all.front().serial);
    } else if (purpose.uses_usb && meant.size() > 1) {
        check.verdict = Verdict::failure;
        check.found = fmt::format("{}: {}", meant.size(), list_of(all));
        check.mend = "springdrive --device usb:" + shell_word(all.front().serial);
    }
    return check;
}

bool has_rule(const Machine &machine) {
    for (const char *const folder : {"/etc/udev/rules.d/", "/run/udev/rules.d/",
                                     "/usr/lib/udev/rules.d/", "/lib/udev/rules.d/"}) {
        for (const std::string &name : machine.names_in(folder)) {
            const auto is_ours = [](const std::string &line) {
                return !line.starts_with("#") &&
                       line.find(fmt::format("\"{:04x}\"", usb::kVendorId)) != std::string::npos;
            };
            if (name.find("springdrive") != std::string::npos &&
                std::ranges::any_of(machine.lines(folder + name), is_ours)) {
                return true;
            }
        }
    }
    return false;
}

std::string install_rule(const Process &process) {
    const std::filesystem::path file = process.setup_folder / "70-springdrive-usb.rules";
    std::error_code unreadable;
    return std::filesystem::is_regular_file(file, unreadable)
               ? fmt::format("{}cp {} /etc/udev/rules.d/", process.sudo(),
                             shell_word(file.string()))
               : fmt::format("echo '{}' | {}tee /etc/udev/rules.d/70-springdrive-usb.rules",
                             udev_rule(), process.sudo());
}

std::string permit(const Evidence &evidence, const Board &board) {
    const Process &process = evidence.process;
    if (evidence.machine.is_container()) {
        return kContainerLine;
    }
    if (!has_rule(evidence.machine)) {
        return install_rule(process) +
               fmt::format(" && {0}udevadm control --reload && {0}udevadm trigger "
                           "--attr-match=idVendor={1:04x}",
                           process.sudo(), usb::kVendorId);
    }
    // The rule is for the person at the screen.
    return process.variable("SSH_CONNECTION").empty()
               ? "unplug the board and plug it in again: the rule for it is installed"
               : fmt::format("{}chown \"$USER\" {}", process.sudo(), board.node());
}

/// Where the kernel has the board, but this system no node for it.
Check no_node(const Evidence &evidence, const Board &board, Check check) {
    check.found = fmt::format("{} is missing, though the kernel has the board at {}", board.node(),
                              board.sysfs_name);
    check.mend =
        evidence.machine.is_container()
            ? kContainerLine
            : fmt::format("{0}mkdir -p {1} && {0}mknod -m 666 {2} c 189 {3}",
                          evidence.process.sudo(), board.node().substr(0, board.node().rfind('/')),
                          board.node(), 128 * (board.bus - 1) + board.address - 1);
    return check;
}

Check permission(const Evidence &evidence, const Board &board) {
    Check check{"usb_permission",
                "permission for " + board.name(),
                evidence.purpose.worse_with_usb(),
                "",
                "a program may use a board only with it",
                ""};
    if (!evidence.machine.exists(board.node()) && board.obstacle != BoardObstacle::none) {
        return no_node(evidence, board, check);
    }
    if (board.obstacle == BoardObstacle::no_permission) {
        check.found = board.node() + " may not be written to";
        check.mend = permit(evidence, board);
        return check;
    }
    if (board.obstacle != BoardObstacle::in_use) {
        check.verdict = Verdict::ok;
        check.found = board.node() + " may be used";
        return check;
    }
    const std::optional<UsingProcess> other = user_of(evidence.machine, board);
    if (other && other->id == evidence.process.parent_id) {
        check.verdict = Verdict::ok; // the window that asks
        check.found = fmt::format("{} is used by the {} that asks", board.node(), other->name);
        return check;
    }
    check.found = fmt::format("{} is used by {}", board.node(),
                              other ? fmt::format("{}, process {}", other->name, other->id)
                                    : "another program");
    check.mend = other ? fmt::format("kill {}", other->id)
                       : evidence.process.sudo() + "fuser -v " + board.node() +
                             "  # names the program to end";
    return check;
}

/// Whether only the board itself can stand in the way of an answer.
bool may_be_asked(const Evidence &evidence, const Board &board) {
    return board.obstacle != BoardObstacle::no_permission &&
           board.obstacle != BoardObstacle::in_use && evidence.machine.exists(board.node());
}

Check firmware(const Evidence &evidence, const Board &board) {
    Check check{"usb_firmware",
                "firmware of " + board.name(),
                Verdict::ok,
                board.firmware,
                "program and firmware must know the same protocol",
                ""};
    if (board.obstacle == BoardObstacle::none) {
        return check;
    }
    if (!may_be_asked(evidence, board)) {
        check.verdict = Verdict::not_applicable;
        check.found = "cannot be asked";
        return check;
    }
    switch (board.obstacle) {
    case BoardObstacle::none:
    case BoardObstacle::no_permission:
    case BoardObstacle::in_use:
        break;
    case BoardObstacle::no_answer:
        check.mend = "unplug the board, switch its power off and on, and plug it in again";
        break;
    case BoardObstacle::no_interface:
    case BoardObstacle::wrong_version:
        check.mend = "install the firmware of this version of springdrive: docs/board.md";
        break;
    }
    check.verdict = evidence.purpose.worse_with_usb();
    check.found += (check.found.empty() ? "" : ": ") + board.problem;
    return check;
}

Check speed(const Evidence &evidence, const Board &board) {
    Check check{"usb_speed",
                "speed of " + board.name(),
                Verdict::ok,
                "",
                "full speed allows a servo of 1000 Hz",
                ""};
    const auto megabits = evidence.machine.text(board.sysfs_folder() + "/speed");
    check.found = megabits ? *megabits + " Mbit/s" : board.speed;
    const bool is_slow = megabits
                             ? *megabits == "12" || *megabits == "1.5"
                             : board.speed.starts_with("full") || board.speed.starts_with("low");
    if (!is_slow) {
        return check;
    }
    const bool is_too_slow = evidence.purpose.servo_hz > kFullSpeedMost_hz ||
                             check.found.find("1.5") != std::string::npos;
    check.verdict = is_too_slow ? evidence.purpose.worse_with_usb() : Verdict::warning;
    check.found += ", full speed or less, instead of 480";
    check.mend = evidence.purpose.servo_hz > kFullSpeedMost_hz
                     ? "springdrive --device usb --servo-hz 1000"
                     : "plug the board into another port, without a hub, by another cable";
    return check;
}

Check autosuspend(const Evidence &evidence, const Board &board) {
    const std::string folder = board.sysfs_folder() + "/power";
    Check check{"usb_autosuspend",
                "autosuspend of " + board.name(),
                Verdict::ok,
                "",
                "a board that was suspended has to be woken before it answers",
                ""};
    const auto control = evidence.machine.text(folder + "/control");
    if (!control) {
        check.verdict = Verdict::not_applicable;
        check.found = "not to be seen here";
        return check;
    }
    check.found = "control is " + *control;
    if (*control == "auto") {
        const auto delay_ms = evidence.machine.number(folder + "/autosuspend_delay_ms");
        check.verdict = Verdict::warning;
        check.found += fmt::format(": suspended {} unused",
                                   delay_ms ? fmt::format("after {} ms", *delay_ms) : "while");
        check.mend = fmt::format("echo on | {}tee {}/control", evidence.process.sudo(), folder);
    }
    return check;
}

Check hub(const Evidence &evidence, const Board &board) {
    Check check{"usb_hub",
                "hubs before " + board.name(),
                Verdict::ok,
                "",
                "a hub delays each packet, and shares its line among its devices",
                ""};
    const std::vector<std::string> hubs = board.hubs();
    if (hubs.empty()) {
        check.found = fmt::format("none: {} is a port of the computer", board.sysfs_name);
        return check;
    }
    check.verdict = Verdict::warning;
    check.found = fmt::format("{} at {}", hubs.size(), board.sysfs_name);
    for (const std::string &name : hubs) {
        const auto product = evidence.machine.text("/sys/bus/usb/devices/" + name + "/product");
        check.found += fmt::format("; {}: {}", name, product.value_or("a hub"));
    }
    check.mend = "plug the board into the computer itself (one hub may be built into it)";
    return check;
}

} // namespace

std::vector<Check> usb_checks(const Evidence &evidence) {
    const UsbTrial &trial = evidence.trials.usb;
    const std::vector<Board> all = boards_of(evidence.machine, trial);
    if (all.empty() && !trial.has_answered) {
        return {{"usb_board", "board on USB", evidence.purpose.worse_with_usb(),
                 "USB gave no answer in time", kMattersUsb,
                 "unplug what hangs on USB, and repeat springdrive doctor"}};
    }
    if (all.empty()) {
        return {absent(evidence)};
    }
    std::vector<Board> meant;
    std::ranges::copy_if(all, std::back_inserter(meant), [&](const Board &board) {
        return evidence.purpose.serial.empty() || board.serial == evidence.purpose.serial;
    });
    std::vector<Check> checks{presence(evidence, all, meant)};
    for (const Board &board : meant) {
        for (auto *const make : {&permission, &firmware, &speed, &autosuspend, &hub}) {
            checks.push_back((*make)(evidence, board));
        }
    }
    return checks;
}

} // namespace springdrive::app::doctor
