// What a participant did: keys and mouse buttons by the names of protocol files, clicks on choices,
// and letters of a free text. The space bar and F12 stop the device and are never among them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::app::study_screen {

enum class InputSource : std::uint8_t {
    key, ///< `name`: see `is_key_name`, or the letter or digit that the keyboard's layout has
         ///< there, lower case; those of the number pad are not told apart
    mouse_button, ///< `name`: one of kMouseButtonNames
    choice,       ///< a click on a plate: `name` is the choice's key, `choice` its index
    letter        ///< of a free text: `name` is one code point in UTF-8
};

struct ParticipantInput {
    InputSource source = InputSource::key;
    std::string name;
    std::size_t choice = 0; ///< index into ParticipantPicture::choices, of a choice only
    double clock_s = 0.0;   ///< of std::chrono::steady_clock, since its epoch, when it was noted
    bool is_press = true;   ///< a release is reported of keys and mouse buttons only

    friend bool operator==(const ParticipantInput &, const ParticipantInput &) = default;
};

inline constexpr std::array<std::string_view, 5> kMouseButtonNames{"left", "right", "middle",
                                                                   "back", "forward"};

/// Whether a key can be reported under this name, which is compared without regard to the case of
/// ASCII letters: that of a key which types nothing ("left", "enter", "f5"), or a single code point
/// that is no space. Whether a keyboard has that letter is not known before it is pressed.
[[nodiscard]] bool is_key_name(std::string_view name);
[[nodiscard]] bool is_mouse_button_name(std::string_view name);

/// The name as events have it: ASCII letters in lower case.
[[nodiscard]] std::string input_name(std::string_view name);

/// What a plate shows for it: arrows for "left", "right", "up", "down" of a keyboard, "↵" for
/// "enter", capital letters; other names as they are. Needs no translation as far as possible.
[[nodiscard]] std::string shown_key(std::string_view name, bool is_mouse);

/// A free text after letters, and backspaces, which take off one code point. Text that would be
/// longer than `max_bytes` is left as it is.
[[nodiscard]] std::string typed_on(std::string text, std::span<const ParticipantInput> inputs,
                                   std::size_t max_bytes = 4000);

/// Names of keys by GLFW's codes: of one that types nothing, and of one that types a letter, by the
/// keyboard's layout. Empty if it has none. @pre of the second: GLFW is initialised
[[nodiscard]] std::string name_of_silent_key(int key);
[[nodiscard]] std::string name_of_letter_key(int key, int scancode);

} // namespace springdrive::app::study_screen
