// One picture of each kind that a participant sees.
#pragma once

#include "app/study/participant/participant_picture.h"

#include <string>
#include <utility>
#include <vector>

namespace springdrive::app::study_screen {

inline std::vector<std::pair<std::string, ParticipantPicture>> pictures_of_a_sitting() {
    const std::string stop = "You may stop the device at any time: press the space bar.";
    ParticipantPicture instructions;
    instructions.heading = "Which one is harder?";
    instructions.text =
        "Hold the stylus as you would hold a pen. You will feel something at its tip, twice.\n"
        "Press gently on the mark, as if to find out how hard it is, and lift the stylus again.\n"
        "Then answer the question. There is no hurry; if you are not sure, guess.";
    instructions.choices = {{"I am ready", "↵"}};
    instructions.footer = stop;
    ParticipantPicture question;
    question.heading = "In which interval did you feel it?";
    question.choices = {{"first", "1"}, {"second", "2"}};
    question.footer = stop;
    question.progress = 0.35;
    ParticipantPicture scale;
    scale.heading = "Wie angestrengt ist Ihre Hand?";
    scale.choices = {{"gar nicht", "1"}, {"", "2"}, {"", "3"},          {"mäßig", "4"},
                     {"", "5"},          {"", "6"}, {"sehr stark", "7"}};
    scale.choices_take_clicks = true;
    scale.chosen = 3;
    ParticipantPicture free_text;
    free_text.heading = "Was haben Sie gespürt?";
    free_text.text = "In eigenen Worten. Enter beendet die Eingabe.";
    free_text.has_text_field = true;
    free_text.typed = "Es fühlte sich an wie Holz, Ω und Ж ";
    ParticipantPicture rest;
    rest.heading = "Rest your hand.";
    rest.left_share = 0.6;
    rest.left_text = "1:12";
    rest.progress = 0.5;
    ParticipantPicture trip;
    trip.heading = "The device has stopped itself, as it should.";
    trip.text = "Let go, and wait a moment. This one did not count, through no fault of yours.";
    trip.is_calm_stop = true;
    trip.progress = 0.5;
    ParticipantPicture scene;
    scene.heading = "1";
    scene.text = "Hold still above the mark.";
    scene.scene = SceneShown::scene;
    scene.tip_m = Vector3(0.0, 0.012, 0.0);
    scene.footer = stop;
    ParticipantPicture answer = scene;
    answer.heading = question.heading;
    answer.text.clear();
    answer.choices = question.choices;
    answer.progress = 0.35;
    return {{"instructions", instructions},
            {"question", question},
            {"scale", scale},
            {"free_text", free_text},
            {"break", rest},
            {"trip", trip},
            {"scene", scene},
            {"scene_answer", answer}};
}

} // namespace springdrive::app::study_screen
