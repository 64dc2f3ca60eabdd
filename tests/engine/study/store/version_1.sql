-- A study that springdrive made when studies were of version 1, of two simulated participants, as
-- `sqlite3 FILE .dump` printed it; the last two lines are of the file's header.
PRAGMA foreign_keys=OFF;
BEGIN TRANSACTION;
CREATE TABLE study (
    id INTEGER PRIMARY KEY CHECK (id = 1),
    title TEXT NOT NULL,
    protocol TEXT NOT NULL,
    protocol_sha256 TEXT NOT NULL CHECK (length(protocol_sha256) = 64),
    created_utc TEXT NOT NULL CHECK (length(created_utc) = 24),
    software TEXT NOT NULL,
    records_folder TEXT NOT NULL CHECK (records_folder <> '' AND records_folder NOT GLOB '*/*'),
    removed_participants INTEGER NOT NULL CHECK (removed_participants >= 0),
    is_to_compact INTEGER NOT NULL CHECK (is_to_compact IN (0, 1)),
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64)
) STRICT;
INSERT INTO study VALUES(1,'a study of version 1',replace('title = "a study of version 1"\nstimulus = "press"\nseed = 7\nparticipants = 2\ncounterbalancing = "balanced_latin_square"\n[texts]\nquestion = "Which?"\n[free_space]\ndR_Ohm = 0.5\nlambda_rad_per_s = 1000.0\n[common]\nscene = "plate"\npoint_m = [0.0, -0.005, -0.015]\nnormal = [0.0, 1.0, 0.0]\nhold = "surface"\nmap = "transpose"\nalpha_mode = "on_the_fly"\ndR_Ohm = 0.5\nK_P_V_per_rad = 6.0\nK_D_Vs_per_rad = 0.01\nservo_hz = 1000.0\ndelay_periods = 0.0\npress_N = 1.0\n[[condition]]\nname = "a"\n[[condition]]\nname = "b"\npress_N = 0.8\n[variable]\nparameter = "eta"\nlevel = "added"\nstandard = 0.4\n[task]\nkind = "forced_choice_by_interval"\nalternatives = 2\n[method]\nkind = "constant_stimuli"\nlevels = [0.1, 0.2, 0.3]\nrepetitions = 1\nblocks = 1\n[practice]\nlevels = [0.3]\nfewest_trials = 1\nmost_trials = 1\n[catch_trials]\nlevels = [0.3]\none_in = 0\n[[block]]\nname = "one"\nconditions = ["a"]\n[[block]]\nname = "two"\nconditions = ["b"]\n[responses]\ndevice = "keyboard"\nkeys = ["1", "2"]\n[timing]\napproach_s = 1.0\npresentation_s = 1.0\n[breaks]\nevery_trials = 20\n[marking]\nstiffness_percent = 5.0\ndirection_deg = 5.0\nforce_percent = 50.0\nrepeats = true\n[windings]\nfrom_C = 27.0\nto_C = 60.0\n[stopping]\nlongest_session_min = 60.0\n[expected]\nthreshold = 0.2\nsource = "a guess"\n','\n',char(10)),'eadb6b88992e7f564ff3c55529ff562f4c1e8567864891a3e871c83b37e5adb5','2026-11-26T04:59:18.295Z','0.1.0','v1.records',0,0,'e9f755bd78656fcdb18f17060373a9b85d6e3e419960724493db4724b09f848e');
CREATE TABLE participant (
    id INTEGER PRIMARY KEY,
    code TEXT NOT NULL UNIQUE CHECK (length(code) BETWEEN 2 AND 7 AND code GLOB '[A-Z]*[0-9]'),
    number INTEGER NOT NULL UNIQUE CHECK (number >= 1),
    added_utc TEXT NOT NULL CHECK (length(added_utc) = 24),
    is_being_removed INTEGER NOT NULL CHECK (is_being_removed IN (0, 1)),
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64)
) STRICT;
INSERT INTO participant VALUES(1,'P01',1,'2026-11-26T04:59:18.610Z',0,'cbf0f1ae6cdf1e2c659d556e7038832b41977b5efaa00a70b859379538785dd2');
INSERT INTO participant VALUES(2,'P02',2,'2026-11-26T04:59:21.431Z',0,'2ac0a67f13af85e4ceb8940bfdd7f998ccbae75d10e069a3891d3834e80c931a');
CREATE TABLE session (
    id INTEGER PRIMARY KEY,
    participant TEXT NOT NULL REFERENCES participant (code) ON DELETE CASCADE,
    started_utc TEXT NOT NULL CHECK (length(started_utc) = 24),
    ended_utc TEXT CHECK (length(ended_utc) = 24),
    ending TEXT CHECK (ending IN ('completed', 'stopped', 'left', 'device_lost', 'safety_trip',
                                  'failed', 'interrupted')),
    device_kind TEXT NOT NULL CHECK (device_kind IN ('simulated', 'emulated', 'usb')),
    device_name TEXT NOT NULL,
    device_serial TEXT NOT NULL,
    software TEXT NOT NULL,
    host TEXT NOT NULL,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    UNIQUE (id, participant),
    CHECK (ended_utc IS NULL OR ending IS NOT NULL)
) STRICT;
INSERT INTO session VALUES(1,'P01','2026-11-26T04:59:18.685Z','2026-11-26T04:59:21.296Z','completed','simulated','PHANTOM 1.0','','0.1.0','AMD EPYC (2 cores)','2e8ab32fa828ecda12402b4b9ecba43b31c0747fec00c2d30b481661bee4eb17');
INSERT INTO session VALUES(2,'P02','2026-11-26T04:59:21.522Z','2026-11-26T04:59:24.016Z','completed','simulated','PHANTOM 1.0','','0.1.0','AMD EPYC (2 cores)','973691784a95aca6b722890ef9f027baec64944abbb980db458a308eb8dafd17');
CREATE TABLE session_fact (
    session INTEGER NOT NULL REFERENCES session ON DELETE CASCADE,
    number INTEGER NOT NULL,
    name TEXT NOT NULL CHECK (name <> ''),
    value ANY NOT NULL CHECK (typeof(value) IN ('real', 'text')),
    PRIMARY KEY (session, number)
) STRICT;
INSERT INTO session_fact VALUES(1,1,'observer_threshold',0.2000000000000000111);
INSERT INTO session_fact VALUES(1,2,'observer_slope',3.5);
INSERT INTO session_fact VALUES(1,3,'observer_guess',0.5);
INSERT INTO session_fact VALUES(1,4,'observer_lapse',0.020000000000000000416);
INSERT INTO session_fact VALUES(1,5,'observer_shape','weibull');
INSERT INTO session_fact VALUES(1,6,'observer_scale','logarithmic');
INSERT INTO session_fact VALUES(1,7,'observer_seed','16890861344412003094');
INSERT INTO session_fact VALUES(1,8,'observer_felt','measured_once');
INSERT INTO session_fact VALUES(2,1,'observer_threshold',0.2000000000000000111);
INSERT INTO session_fact VALUES(2,2,'observer_slope',3.5);
INSERT INTO session_fact VALUES(2,3,'observer_guess',0.5);
INSERT INTO session_fact VALUES(2,4,'observer_lapse',0.020000000000000000416);
INSERT INTO session_fact VALUES(2,5,'observer_shape','weibull');
INSERT INTO session_fact VALUES(2,6,'observer_scale','logarithmic');
INSERT INTO session_fact VALUES(2,7,'observer_seed','6810980681300906961');
INSERT INTO session_fact VALUES(2,8,'observer_felt','measured_once');
CREATE TABLE trial (
    id INTEGER PRIMARY KEY,
    participant TEXT NOT NULL REFERENCES participant (code) ON DELETE CASCADE,
    block INTEGER NOT NULL CHECK (block >= 1),
    position INTEGER NOT NULL CHECK (position >= 1),
    attempt INTEGER NOT NULL CHECK (attempt >= 1),
    session INTEGER NOT NULL,
    condition TEXT NOT NULL,
    track TEXT NOT NULL,
    is_practice INTEGER NOT NULL CHECK (is_practice IN (0, 1)),
    is_catch INTEGER NOT NULL CHECK (is_catch IN (0, 1)),
    is_presented_again INTEGER NOT NULL CHECK (is_presented_again IN (0, 1)),
    seed INTEGER NOT NULL,
    level_name TEXT NOT NULL,
    level ANY CHECK (typeof(level) IN ('real', 'null')),
    target INTEGER,
    response TEXT NOT NULL,
    chosen INTEGER,
    adjusted ANY,
    is_correct INTEGER CHECK (is_correct IN (0, 1)),
    response_time_s ANY CHECK (typeof(response_time_s) IN ('real', 'null')),
    at_utc TEXT NOT NULL CHECK (length(at_utc) = 24),
    software TEXT NOT NULL,
    missed_deadlines INTEGER NOT NULL CHECK (missed_deadlines >= 0),
    record_path TEXT CHECK (record_path <> '' AND record_path NOT GLOB '/*'),
    record_sha256 TEXT CHECK (length(record_sha256) = 64),
    repeats_block INTEGER,
    repeats_position INTEGER,
    repeats_attempt INTEGER,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    UNIQUE (participant, block, position, attempt),
    UNIQUE (participant, repeats_block, repeats_position, repeats_attempt),
    FOREIGN KEY (session, participant) REFERENCES session (id, participant) ON DELETE CASCADE,
    FOREIGN KEY (participant, repeats_block, repeats_position, repeats_attempt)
        REFERENCES trial (participant, block, position, attempt) ON DELETE CASCADE,
    CHECK ((record_path IS NULL) = (record_sha256 IS NULL)),
    CHECK ((repeats_block IS NULL) = (repeats_position IS NULL)
           AND (repeats_block IS NULL) = (repeats_attempt IS NULL)),
    CHECK (CASE response
               WHEN 'none' THEN chosen IS NULL AND adjusted IS NULL
               WHEN 'chosen' THEN chosen >= 1 AND adjusted IS NULL
               WHEN 'yes_no' THEN chosen IN (0, 1) AND adjusted IS NULL
               WHEN 'adjusted' THEN chosen IS NULL AND typeof(adjusted) = 'real'
               ELSE 0 END)
) STRICT;
INSERT INTO trial VALUES(1,'P01',1,1,1,1,'a','',1,0,0,3185090318772920569,'eta_added',0.29999999999999998889,1,'chosen',1,NULL,1,0.61459644309508520976,'2026-11-26T04:59:19.350Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'5945be25d9930137c7f45b54bae97221fa7150d2caeffc56b2410a7ec671f131');
INSERT INTO trial VALUES(2,'P01',1,2,1,1,'a','',0,0,0,128944023305872304,'eta_added',0.29999999999999998889,1,'chosen',1,NULL,1,0.58199661392478041488,'2026-11-26T04:59:19.411Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'84dfb264903511543e2017c6c63f337f88aeebae86afbfebc035fc1c1ace9390');
INSERT INTO trial VALUES(3,'P01',1,3,1,1,'a','',0,0,0,3349428499388832370,'eta_added',0.2000000000000000111,1,'chosen',1,NULL,1,0.98289311894872966046,'2026-11-26T04:59:19.785Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'ac5bc76e57e633f70c5aedbdda6d2f8849d4098306909095c423e34c4b395b9f');
INSERT INTO trial VALUES(4,'P01',1,4,1,1,'a','',0,0,0,8883392259264006529,'eta_added',0.10000000000000000555,2,'chosen',2,NULL,1,0.41940325700190805857,'2026-11-26T04:59:20.099Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'fda534900f00179a0e81e6b5911387a52dbcad8782b043712eaeed5130d55093');
INSERT INTO trial VALUES(5,'P01',2,1,1,1,'b','',0,0,0,-8757781744549401161,'eta_added',0.29999999999999998889,2,'chosen',2,NULL,1,0.91394603640023275303,'2026-11-26T04:59:20.626Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'5bebf5d9293a88a2162d019b63392eb47c9995566664c5e042434ca9c3c6d69a');
INSERT INTO trial VALUES(6,'P01',2,2,1,1,'b','',0,0,0,8383380209088741875,'eta_added',0.10000000000000000555,2,'chosen',2,NULL,1,0.61709025771058245712,'2026-11-26T04:59:20.875Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'d102f5ad4c266177099cbcc7a89b5be01dfa2ff306bf90fa19686e199d8690db');
INSERT INTO trial VALUES(7,'P01',2,3,1,1,'b','',0,0,0,2133502766555474726,'eta_added',0.2000000000000000111,2,'chosen',2,NULL,1,0.74807338566295533688,'2026-11-26T04:59:21.218Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'0fafceb34df2c3ea60fca69ac97131d54257d3c65c2ca584ffaf73fee4dc9ca7');
INSERT INTO trial VALUES(8,'P02',1,1,1,2,'b','',1,0,0,195324624426857574,'eta_added',0.29999999999999998889,1,'chosen',1,NULL,1,0.71811775808655997632,'2026-11-26T04:59:22.023Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'091f7cfecbcc74781450ad037bc293f4770d15166505b5dbf2651de63f54c3e0');
INSERT INTO trial VALUES(9,'P02',1,2,1,2,'b','',0,0,0,-3924146196498028208,'eta_added',0.10000000000000000555,1,'chosen',2,NULL,0,0.77977044805051309861,'2026-11-26T04:59:22.345Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'0d693cf4122b553cd58095c1eda2886d76f4972000b30634e3ad8e4a93655158');
INSERT INTO trial VALUES(10,'P02',1,3,1,2,'b','',0,0,0,3790253821584939469,'eta_added',0.2000000000000000111,1,'chosen',2,NULL,0,0.4632045067675118477,'2026-11-26T04:59:22.678Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'1596484eee06375e84497b5ba3c2fa380ff0e23ff842a5503ef1d3f071c4696f');
INSERT INTO trial VALUES(11,'P02',1,4,1,2,'b','',0,0,0,922308447163759814,'eta_added',0.29999999999999998889,1,'chosen',1,NULL,1,0.38414909669672975267,'2026-11-26T04:59:22.790Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'d6adfa32b421a6e0c855fe6c5228eb0aac4e117196678ca44a8064a5df0c101c');
INSERT INTO trial VALUES(12,'P02',2,1,1,2,'a','',0,0,0,7490621896499329268,'eta_added',0.29999999999999998889,1,'chosen',1,NULL,1,1.0890008028065483181,'2026-11-26T04:59:23.311Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'3a6f565be203fc3ed1c445d5c0852f74b4e691b1867a37a948fb30a642b8a291');
INSERT INTO trial VALUES(13,'P02',2,2,1,2,'a','',0,0,0,-6952516982675556308,'eta_added',0.2000000000000000111,2,'chosen',2,NULL,1,0.63428134814197023594,'2026-11-26T04:59:23.620Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'0946a39889ea2504c46bc55b6e099cb50cbbe3b8a9890c4c7473eddd93bdd7ed');
INSERT INTO trial VALUES(14,'P02',2,3,1,2,'a','',0,0,0,7790531969485332262,'eta_added',0.10000000000000000555,1,'chosen',2,NULL,0,0.64103728629153822193,'2026-11-26T04:59:23.934Z','0.1.0',0,NULL,NULL,NULL,NULL,NULL,'dc1a167e8a6ab49a24766e1f2d422d5e3cc79de34cb3e5201e2bf710cf18e961');
CREATE TABLE presentation (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    start_s ANY CHECK (typeof(start_s) IN ('real', 'null')),
    end_s ANY CHECK (typeof(end_s) IN ('real', 'null')),
    PRIMARY KEY (trial, number)
) STRICT;
INSERT INTO presentation VALUES(1,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(1,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(2,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(2,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(3,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(3,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(4,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(4,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(5,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(5,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(6,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(6,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(7,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(7,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(8,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(8,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(9,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(9,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(10,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(10,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(11,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(11,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(12,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(12,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(13,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(13,2,5.9809999999999998721,6.9800000000000004263);
INSERT INTO presentation VALUES(14,1,2.241000000000000103,3.2400000000000002131);
INSERT INTO presentation VALUES(14,2,5.9809999999999998721,6.9800000000000004263);
CREATE TABLE stimulus_value (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    presentation INTEGER NOT NULL,
    name TEXT NOT NULL CHECK (name <> ''),
    intended ANY CHECK (typeof(intended) IN ('real', 'null')),
    delivered ANY CHECK (typeof(delivered) IN ('real', 'null')),
    PRIMARY KEY (trial, number),
    FOREIGN KEY (trial, presentation) REFERENCES presentation ON DELETE CASCADE
) STRICT;
INSERT INTO stimulus_value VALUES(1,1,1,'direction_deg',0.0,0.00094530601635199802169);
INSERT INTO stimulus_value VALUES(1,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(1,3,1,'stiffness_N_per_m',508.32306383126143601,515.0252583674832749);
INSERT INTO stimulus_value VALUES(1,4,1,'press_N',1.0,1.030012290685163645);
INSERT INTO stimulus_value VALUES(1,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(1,6,1,'peak_force_N',NULL,1.0678544477757465624);
INSERT INTO stimulus_value VALUES(1,7,1,'aside_m',NULL,9.8055670195829058854e-05);
INSERT INTO stimulus_value VALUES(1,8,2,'direction_deg',0.0,0.00080970959559635623335);
INSERT INTO stimulus_value VALUES(1,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(1,10,2,'stiffness_N_per_m',1016.6461276625226446,1023.1074327085611912);
INSERT INTO stimulus_value VALUES(1,11,2,'press_N',1.0,1.0295923343232886715);
INSERT INTO stimulus_value VALUES(1,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(1,13,2,'peak_force_N',NULL,1.0489273832365646477);
INSERT INTO stimulus_value VALUES(1,14,2,'aside_m',NULL,4.4954036342387260205e-05);
INSERT INTO stimulus_value VALUES(2,1,1,'direction_deg',0.0,0.00094530601635199802169);
INSERT INTO stimulus_value VALUES(2,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(2,3,1,'stiffness_N_per_m',508.32306383126143601,515.0252583674832749);
INSERT INTO stimulus_value VALUES(2,4,1,'press_N',1.0,1.030012290685163645);
INSERT INTO stimulus_value VALUES(2,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(2,6,1,'peak_force_N',NULL,1.0678544477757465624);
INSERT INTO stimulus_value VALUES(2,7,1,'aside_m',NULL,9.8055670195829058854e-05);
INSERT INTO stimulus_value VALUES(2,8,2,'direction_deg',0.0,0.00080970959559635623335);
INSERT INTO stimulus_value VALUES(2,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(2,10,2,'stiffness_N_per_m',1016.6461276625226446,1023.1074327085611912);
INSERT INTO stimulus_value VALUES(2,11,2,'press_N',1.0,1.0295923343232886715);
INSERT INTO stimulus_value VALUES(2,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(2,13,2,'peak_force_N',NULL,1.0489273832365646477);
INSERT INTO stimulus_value VALUES(2,14,2,'aside_m',NULL,4.4954036342387260205e-05);
INSERT INTO stimulus_value VALUES(3,1,1,'direction_deg',0.0,0.00092585094120526810913);
INSERT INTO stimulus_value VALUES(3,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(3,3,1,'stiffness_N_per_m',677.76408510834835396,684.38322128319725836);
INSERT INTO stimulus_value VALUES(3,4,1,'press_N',1.0,1.0287500954426029853);
INSERT INTO stimulus_value VALUES(3,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(3,6,1,'peak_force_N',NULL,1.0586299331547370794);
INSERT INTO stimulus_value VALUES(3,7,1,'aside_m',NULL,7.1087246678008808586e-05);
INSERT INTO stimulus_value VALUES(3,8,2,'direction_deg',0.0,0.00080970959559635623335);
INSERT INTO stimulus_value VALUES(3,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(3,10,2,'stiffness_N_per_m',1016.6461276625226446,1023.1074327085611912);
INSERT INTO stimulus_value VALUES(3,11,2,'press_N',1.0,1.0295923343232886715);
INSERT INTO stimulus_value VALUES(3,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(3,13,2,'peak_force_N',NULL,1.0489273832365646477);
INSERT INTO stimulus_value VALUES(3,14,2,'aside_m',NULL,4.4954036342387260205e-05);
INSERT INTO stimulus_value VALUES(4,1,1,'direction_deg',0.0,0.00080970959559635623335);
INSERT INTO stimulus_value VALUES(4,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(4,3,1,'stiffness_N_per_m',1016.6461276625226446,1023.1074327085611912);
INSERT INTO stimulus_value VALUES(4,4,1,'press_N',1.0,1.0295923343232886715);
INSERT INTO stimulus_value VALUES(4,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(4,6,1,'peak_force_N',NULL,1.0489273832365646477);
INSERT INTO stimulus_value VALUES(4,7,1,'aside_m',NULL,4.4954036342387260205e-05);
INSERT INTO stimulus_value VALUES(4,8,2,'direction_deg',0.0,0.00076066215704483281564);
INSERT INTO stimulus_value VALUES(4,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(4,10,2,'stiffness_N_per_m',847.20510638543555619,853.68478615085541605);
INSERT INTO stimulus_value VALUES(4,11,2,'press_N',1.0,1.0222374232252480208);
INSERT INTO stimulus_value VALUES(4,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(4,13,2,'peak_force_N',NULL,1.0464065756432510134);
INSERT INTO stimulus_value VALUES(4,14,2,'aside_m',NULL,5.5370581284991393644e-05);
INSERT INTO stimulus_value VALUES(5,1,1,'direction_deg',0.0,0.0013128071102716121903);
INSERT INTO stimulus_value VALUES(5,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(5,3,1,'stiffness_N_per_m',1016.6461276625226446,1021.8399153069833573);
INSERT INTO stimulus_value VALUES(5,4,1,'press_N',0.8000000000000000444,0.83302719381927770037);
INSERT INTO stimulus_value VALUES(5,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(5,6,1,'peak_force_N',NULL,0.83391634574938044988);
INSERT INTO stimulus_value VALUES(5,7,1,'aside_m',NULL,3.5759285009678842826e-05);
INSERT INTO stimulus_value VALUES(5,8,2,'direction_deg',0.0,0.00053757404831734120331);
INSERT INTO stimulus_value VALUES(5,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(5,10,2,'stiffness_N_per_m',508.32306383126143601,513.57130280492742711);
INSERT INTO stimulus_value VALUES(5,11,2,'press_N',0.8000000000000000444,0.82105371130471205276);
INSERT INTO stimulus_value VALUES(5,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(5,13,2,'peak_force_N',NULL,0.86561305160403123615);
INSERT INTO stimulus_value VALUES(5,14,2,'aside_m',NULL,7.6136100275348006505e-05);
INSERT INTO stimulus_value VALUES(6,1,1,'direction_deg',0.0,0.0013128071102716121903);
INSERT INTO stimulus_value VALUES(6,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(6,3,1,'stiffness_N_per_m',1016.6461276625226446,1021.8399153069833573);
INSERT INTO stimulus_value VALUES(6,4,1,'press_N',0.8000000000000000444,0.83302719381927770037);
INSERT INTO stimulus_value VALUES(6,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(6,6,1,'peak_force_N',NULL,0.83391634574938044988);
INSERT INTO stimulus_value VALUES(6,7,1,'aside_m',NULL,3.5759285009678842826e-05);
INSERT INTO stimulus_value VALUES(6,8,2,'direction_deg',0.0,0.0011273321837124343578);
INSERT INTO stimulus_value VALUES(6,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(6,10,2,'stiffness_N_per_m',847.20510638543555619,852.38604374471799475);
INSERT INTO stimulus_value VALUES(6,11,2,'press_N',0.8000000000000000444,0.82520883905979947048);
INSERT INTO stimulus_value VALUES(6,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(6,13,2,'peak_force_N',NULL,0.83154647861262620534);
INSERT INTO stimulus_value VALUES(6,14,2,'aside_m',NULL,4.3094145661892735432e-05);
INSERT INTO stimulus_value VALUES(7,1,1,'direction_deg',0.0,0.0013128071102716121903);
INSERT INTO stimulus_value VALUES(7,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(7,3,1,'stiffness_N_per_m',1016.6461276625226446,1021.8399153069833573);
INSERT INTO stimulus_value VALUES(7,4,1,'press_N',0.8000000000000000444,0.83302719381927770037);
INSERT INTO stimulus_value VALUES(7,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(7,6,1,'peak_force_N',NULL,0.83391634574938044988);
INSERT INTO stimulus_value VALUES(7,7,1,'aside_m',NULL,3.5759285009678842826e-05);
INSERT INTO stimulus_value VALUES(7,8,2,'direction_deg',0.0,0.00090842555485563726992);
INSERT INTO stimulus_value VALUES(7,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(7,10,2,'stiffness_N_per_m',677.76408510834835396,682.94188559007488947);
INSERT INTO stimulus_value VALUES(7,11,2,'press_N',0.8000000000000000444,0.81778282179064298862);
INSERT INTO stimulus_value VALUES(7,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(7,13,2,'peak_force_N',NULL,0.83856815497932757352);
INSERT INTO stimulus_value VALUES(7,14,2,'aside_m',NULL,5.4410535861554309988e-05);
INSERT INTO stimulus_value VALUES(8,1,1,'direction_deg',0.0,0.00053757404831734120331);
INSERT INTO stimulus_value VALUES(8,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(8,3,1,'stiffness_N_per_m',508.32306383126143601,513.57130280492742711);
INSERT INTO stimulus_value VALUES(8,4,1,'press_N',0.8000000000000000444,0.82105371130471205276);
INSERT INTO stimulus_value VALUES(8,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(8,6,1,'peak_force_N',NULL,0.86561305160403123615);
INSERT INTO stimulus_value VALUES(8,7,1,'aside_m',NULL,7.6136100275348006505e-05);
INSERT INTO stimulus_value VALUES(8,8,2,'direction_deg',0.0,0.0013128071102716121903);
INSERT INTO stimulus_value VALUES(8,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(8,10,2,'stiffness_N_per_m',1016.6461276625226446,1021.8399153069833573);
INSERT INTO stimulus_value VALUES(8,11,2,'press_N',0.8000000000000000444,0.83302719381927770037);
INSERT INTO stimulus_value VALUES(8,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(8,13,2,'peak_force_N',NULL,0.83391634574938044988);
INSERT INTO stimulus_value VALUES(8,14,2,'aside_m',NULL,3.5759285009678842826e-05);
INSERT INTO stimulus_value VALUES(9,1,1,'direction_deg',0.0,0.0011273321837124343578);
INSERT INTO stimulus_value VALUES(9,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(9,3,1,'stiffness_N_per_m',847.20510638543555619,852.38604374471799475);
INSERT INTO stimulus_value VALUES(9,4,1,'press_N',0.8000000000000000444,0.82520883905979947048);
INSERT INTO stimulus_value VALUES(9,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(9,6,1,'peak_force_N',NULL,0.83154647861262620534);
INSERT INTO stimulus_value VALUES(9,7,1,'aside_m',NULL,4.3094145661892735432e-05);
INSERT INTO stimulus_value VALUES(9,8,2,'direction_deg',0.0,0.0013128071102716121903);
INSERT INTO stimulus_value VALUES(9,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(9,10,2,'stiffness_N_per_m',1016.6461276625226446,1021.8399153069833573);
INSERT INTO stimulus_value VALUES(9,11,2,'press_N',0.8000000000000000444,0.83302719381927770037);
INSERT INTO stimulus_value VALUES(9,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(9,13,2,'peak_force_N',NULL,0.83391634574938044988);
INSERT INTO stimulus_value VALUES(9,14,2,'aside_m',NULL,3.5759285009678842826e-05);
INSERT INTO stimulus_value VALUES(10,1,1,'direction_deg',0.0,0.00090842555485563726992);
INSERT INTO stimulus_value VALUES(10,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(10,3,1,'stiffness_N_per_m',677.76408510834835396,682.94188559007488947);
INSERT INTO stimulus_value VALUES(10,4,1,'press_N',0.8000000000000000444,0.81778282179064298862);
INSERT INTO stimulus_value VALUES(10,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(10,6,1,'peak_force_N',NULL,0.83856815497932757352);
INSERT INTO stimulus_value VALUES(10,7,1,'aside_m',NULL,5.4410535861554309988e-05);
INSERT INTO stimulus_value VALUES(10,8,2,'direction_deg',0.0,0.0013128071102716121903);
INSERT INTO stimulus_value VALUES(10,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(10,10,2,'stiffness_N_per_m',1016.6461276625226446,1021.8399153069833573);
INSERT INTO stimulus_value VALUES(10,11,2,'press_N',0.8000000000000000444,0.83302719381927770037);
INSERT INTO stimulus_value VALUES(10,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(10,13,2,'peak_force_N',NULL,0.83391634574938044988);
INSERT INTO stimulus_value VALUES(10,14,2,'aside_m',NULL,3.5759285009678842826e-05);
INSERT INTO stimulus_value VALUES(11,1,1,'direction_deg',0.0,0.00053757404831734120331);
INSERT INTO stimulus_value VALUES(11,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(11,3,1,'stiffness_N_per_m',508.32306383126143601,513.57130280492742711);
INSERT INTO stimulus_value VALUES(11,4,1,'press_N',0.8000000000000000444,0.82105371130471205276);
INSERT INTO stimulus_value VALUES(11,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(11,6,1,'peak_force_N',NULL,0.86561305160403123615);
INSERT INTO stimulus_value VALUES(11,7,1,'aside_m',NULL,7.6136100275348006505e-05);
INSERT INTO stimulus_value VALUES(11,8,2,'direction_deg',0.0,0.0013128071102716121903);
INSERT INTO stimulus_value VALUES(11,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(11,10,2,'stiffness_N_per_m',1016.6461276625226446,1021.8399153069833573);
INSERT INTO stimulus_value VALUES(11,11,2,'press_N',0.8000000000000000444,0.83302719381927770037);
INSERT INTO stimulus_value VALUES(11,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(11,13,2,'peak_force_N',NULL,0.83391634574938044988);
INSERT INTO stimulus_value VALUES(11,14,2,'aside_m',NULL,3.5759285009678842826e-05);
INSERT INTO stimulus_value VALUES(12,1,1,'direction_deg',0.0,0.00094530601635199802169);
INSERT INTO stimulus_value VALUES(12,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(12,3,1,'stiffness_N_per_m',508.32306383126143601,515.0252583674832749);
INSERT INTO stimulus_value VALUES(12,4,1,'press_N',1.0,1.030012290685163645);
INSERT INTO stimulus_value VALUES(12,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(12,6,1,'peak_force_N',NULL,1.0678544477757465624);
INSERT INTO stimulus_value VALUES(12,7,1,'aside_m',NULL,9.8055670195829058854e-05);
INSERT INTO stimulus_value VALUES(12,8,2,'direction_deg',0.0,0.00080970959559635623335);
INSERT INTO stimulus_value VALUES(12,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(12,10,2,'stiffness_N_per_m',1016.6461276625226446,1023.1074327085611912);
INSERT INTO stimulus_value VALUES(12,11,2,'press_N',1.0,1.0295923343232886715);
INSERT INTO stimulus_value VALUES(12,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(12,13,2,'peak_force_N',NULL,1.0489273832365646477);
INSERT INTO stimulus_value VALUES(12,14,2,'aside_m',NULL,4.4954036342387260205e-05);
INSERT INTO stimulus_value VALUES(13,1,1,'direction_deg',0.0,0.00080970959559635623335);
INSERT INTO stimulus_value VALUES(13,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(13,3,1,'stiffness_N_per_m',1016.6461276625226446,1023.1074327085611912);
INSERT INTO stimulus_value VALUES(13,4,1,'press_N',1.0,1.0295923343232886715);
INSERT INTO stimulus_value VALUES(13,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(13,6,1,'peak_force_N',NULL,1.0489273832365646477);
INSERT INTO stimulus_value VALUES(13,7,1,'aside_m',NULL,4.4954036342387260205e-05);
INSERT INTO stimulus_value VALUES(13,8,2,'direction_deg',0.0,0.00092585094120526810913);
INSERT INTO stimulus_value VALUES(13,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(13,10,2,'stiffness_N_per_m',677.76408510834835396,684.38322128319725836);
INSERT INTO stimulus_value VALUES(13,11,2,'press_N',1.0,1.0287500954426029853);
INSERT INTO stimulus_value VALUES(13,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(13,13,2,'peak_force_N',NULL,1.0586299331547370794);
INSERT INTO stimulus_value VALUES(13,14,2,'aside_m',NULL,7.1087246678008808586e-05);
INSERT INTO stimulus_value VALUES(14,1,1,'direction_deg',0.0,0.00076066215704483281564);
INSERT INTO stimulus_value VALUES(14,2,1,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(14,3,1,'stiffness_N_per_m',847.20510638543555619,853.68478615085541605);
INSERT INTO stimulus_value VALUES(14,4,1,'press_N',1.0,1.0222374232252480208);
INSERT INTO stimulus_value VALUES(14,5,1,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(14,6,1,'peak_force_N',NULL,1.0464065756432510134);
INSERT INTO stimulus_value VALUES(14,7,1,'aside_m',NULL,5.5370581284991393644e-05);
INSERT INTO stimulus_value VALUES(14,8,2,'direction_deg',0.0,0.00080970959559635623335);
INSERT INTO stimulus_value VALUES(14,9,2,'direction_across_deg',0.0,0.0);
INSERT INTO stimulus_value VALUES(14,10,2,'stiffness_N_per_m',1016.6461276625226446,1023.1074327085611912);
INSERT INTO stimulus_value VALUES(14,11,2,'press_N',1.0,1.0295923343232886715);
INSERT INTO stimulus_value VALUES(14,12,2,'lateness_s',0.0,0.0);
INSERT INTO stimulus_value VALUES(14,13,2,'peak_force_N',NULL,1.0489273832365646477);
INSERT INTO stimulus_value VALUES(14,14,2,'aside_m',NULL,4.4954036342387260205e-05);
CREATE TABLE tuning_value (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    name TEXT NOT NULL CHECK (name <> ''),
    value ANY NOT NULL CHECK (typeof(value) IN ('real', 'text')),
    PRIMARY KEY (trial, number)
) STRICT;
INSERT INTO tuning_value VALUES(1,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(1,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(1,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(1,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(1,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(1,6,'eta',0.69999999999999995559);
INSERT INTO tuning_value VALUES(1,7,'map','transpose');
INSERT INTO tuning_value VALUES(1,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(1,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(1,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(2,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(2,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(2,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(2,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(2,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(2,6,'eta',0.69999999999999995559);
INSERT INTO tuning_value VALUES(2,7,'map','transpose');
INSERT INTO tuning_value VALUES(2,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(2,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(2,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(3,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(3,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(3,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(3,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(3,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(3,6,'eta',0.60000000000000008881);
INSERT INTO tuning_value VALUES(3,7,'map','transpose');
INSERT INTO tuning_value VALUES(3,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(3,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(3,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(4,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(4,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(4,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(4,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(4,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(4,6,'eta',0.5);
INSERT INTO tuning_value VALUES(4,7,'map','transpose');
INSERT INTO tuning_value VALUES(4,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(4,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(4,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(5,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(5,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(5,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(5,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(5,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(5,6,'eta',0.69999999999999995559);
INSERT INTO tuning_value VALUES(5,7,'map','transpose');
INSERT INTO tuning_value VALUES(5,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(5,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(5,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(6,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(6,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(6,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(6,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(6,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(6,6,'eta',0.5);
INSERT INTO tuning_value VALUES(6,7,'map','transpose');
INSERT INTO tuning_value VALUES(6,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(6,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(6,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(7,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(7,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(7,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(7,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(7,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(7,6,'eta',0.60000000000000008881);
INSERT INTO tuning_value VALUES(7,7,'map','transpose');
INSERT INTO tuning_value VALUES(7,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(7,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(7,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(8,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(8,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(8,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(8,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(8,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(8,6,'eta',0.69999999999999995559);
INSERT INTO tuning_value VALUES(8,7,'map','transpose');
INSERT INTO tuning_value VALUES(8,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(8,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(8,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(9,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(9,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(9,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(9,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(9,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(9,6,'eta',0.5);
INSERT INTO tuning_value VALUES(9,7,'map','transpose');
INSERT INTO tuning_value VALUES(9,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(9,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(9,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(10,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(10,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(10,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(10,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(10,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(10,6,'eta',0.60000000000000008881);
INSERT INTO tuning_value VALUES(10,7,'map','transpose');
INSERT INTO tuning_value VALUES(10,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(10,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(10,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(11,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(11,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(11,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(11,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(11,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(11,6,'eta',0.69999999999999995559);
INSERT INTO tuning_value VALUES(11,7,'map','transpose');
INSERT INTO tuning_value VALUES(11,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(11,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(11,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(12,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(12,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(12,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(12,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(12,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(12,6,'eta',0.69999999999999995559);
INSERT INTO tuning_value VALUES(12,7,'map','transpose');
INSERT INTO tuning_value VALUES(12,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(12,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(12,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(13,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(13,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(13,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(13,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(13,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(13,6,'eta',0.60000000000000008881);
INSERT INTO tuning_value VALUES(13,7,'map','transpose');
INSERT INTO tuning_value VALUES(13,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(13,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(13,10,'delay_periods',0.0);
INSERT INTO tuning_value VALUES(14,1,'dR_Ohm',0.5);
INSERT INTO tuning_value VALUES(14,2,'K_P_V_per_rad',6.0);
INSERT INTO tuning_value VALUES(14,3,'K_D_Vs_per_rad',0.010000000000000000208);
INSERT INTO tuning_value VALUES(14,4,'lambda_rad_per_s',1000.0);
INSERT INTO tuning_value VALUES(14,5,'alpha_rad2_per_m2',3000.0);
INSERT INTO tuning_value VALUES(14,6,'eta',0.5);
INSERT INTO tuning_value VALUES(14,7,'map','transpose');
INSERT INTO tuning_value VALUES(14,8,'alpha_mode','on_the_fly');
INSERT INTO tuning_value VALUES(14,9,'servo_hz',1000.0);
INSERT INTO tuning_value VALUES(14,10,'delay_periods',0.0);
CREATE TABLE winding (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    temperature_degC ANY CHECK (typeof(temperature_degC) IN ('real', 'null')),
    PRIMARY KEY (trial, number)
) STRICT;
INSERT INTO winding VALUES(1,1,25.0);
INSERT INTO winding VALUES(1,2,25.180758764556529171);
INSERT INTO winding VALUES(1,3,25.002105271573526578);
INSERT INTO winding VALUES(2,1,25.0);
INSERT INTO winding VALUES(2,2,25.180758764556529171);
INSERT INTO winding VALUES(2,3,25.002105271573526578);
INSERT INTO winding VALUES(3,1,25.0);
INSERT INTO winding VALUES(3,2,25.180758764556529171);
INSERT INTO winding VALUES(3,3,25.002105271573526578);
INSERT INTO winding VALUES(4,1,25.0);
INSERT INTO winding VALUES(4,2,25.178493587974024592);
INSERT INTO winding VALUES(4,3,25.002077924007707564);
INSERT INTO winding VALUES(5,1,25.0);
INSERT INTO winding VALUES(5,2,25.115030209550585737);
INSERT INTO winding VALUES(5,3,25.001349024259035048);
INSERT INTO winding VALUES(6,1,25.0);
INSERT INTO winding VALUES(6,2,25.116112752455229894);
INSERT INTO winding VALUES(6,3,25.001360791509618763);
INSERT INTO winding VALUES(7,1,25.0);
INSERT INTO winding VALUES(7,2,25.114178117940230805);
INSERT INTO winding VALUES(7,3,25.001338696157930029);
INSERT INTO winding VALUES(8,1,25.0);
INSERT INTO winding VALUES(8,2,25.118152831867476492);
INSERT INTO winding VALUES(8,3,25.001384725781310436);
INSERT INTO winding VALUES(9,1,25.0);
INSERT INTO winding VALUES(9,2,25.118152831867476492);
INSERT INTO winding VALUES(9,3,25.001384725781310436);
INSERT INTO winding VALUES(10,1,25.0);
INSERT INTO winding VALUES(10,2,25.118152831867476492);
INSERT INTO winding VALUES(10,3,25.001384725781310436);
INSERT INTO winding VALUES(11,1,25.0);
INSERT INTO winding VALUES(11,2,25.118152831867476492);
INSERT INTO winding VALUES(11,3,25.001384725781310436);
INSERT INTO winding VALUES(12,1,25.0);
INSERT INTO winding VALUES(12,2,25.180758764556529171);
INSERT INTO winding VALUES(12,3,25.002105271573526578);
INSERT INTO winding VALUES(13,1,25.0);
INSERT INTO winding VALUES(13,2,25.180562961773439666);
INSERT INTO winding VALUES(13,3,25.002101150827549247);
INSERT INTO winding VALUES(14,1,25.0);
INSERT INTO winding VALUES(14,2,25.180758764556529171);
INSERT INTO winding VALUES(14,3,25.002105271573526578);
CREATE TABLE safety_event (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    time_s ANY CHECK (typeof(time_s) IN ('real', 'null')),
    text TEXT NOT NULL,
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE mark (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    reason TEXT NOT NULL CHECK (reason <> ''),
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE note (
    id INTEGER PRIMARY KEY,
    participant TEXT REFERENCES participant (code) ON DELETE CASCADE,
    session INTEGER,
    at_utc TEXT NOT NULL CHECK (length(at_utc) = 24),
    kind TEXT NOT NULL CHECK (kind <> ''),
    text TEXT NOT NULL,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    FOREIGN KEY (session, participant) REFERENCES session (id, participant) ON DELETE CASCADE,
    CHECK (session IS NULL OR participant IS NOT NULL)
) STRICT;
INSERT INTO note VALUES(1,NULL,NULL,'2026-11-26T04:59:24.588Z','note','the room is warm','680ab0579e1d8ec7cd7257123994d129885751594cab45d6e3c23f684e0e24df');
INSERT INTO note VALUES(2,'P02',NULL,'2026-11-26T04:59:25.104Z','note','drank water','5a2e7047e7d022303e627ed066715664c1ff933e0570e97b4fc657c9cc15ce3c');
COMMIT;
PRAGMA application_id = 1396986708;
PRAGMA user_version = 1;
