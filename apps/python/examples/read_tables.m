% Knee angle of a trial, and how long each rise took, in MATLAB (R2019b or later). Set folder to one of `lake track`.
folder = 'lake-out/human';
knee = readtable(fullfile(folder, 'kinematics.csv'));        % an empty cell is NaN
events = readtable(fullfile(folder, 'events.csv'), 'TextType', 'string');

onset = events(events.event == "onset", {'repetition', 'time_s'});
standing = events(events.event == "standing", {'repetition', 'time_s'});
rises = innerjoin(onset, standing, 'Keys', 'repetition');
rises.rise_s = rises.time_s_standing - rises.time_s_onset;
disp(rises(:, {'repetition', 'rise_s'}))
fprintf('knee angle from %.1f to %.1f degrees\n', min(knee.knee_deg), max(knee.knee_deg));

plot(knee.time_s, knee.knee_deg)
xlabel('time, s'), ylabel('knee angle, degrees')

summary = jsondecode(fileread(fullfile(folder, 'summary.json')));   % version, options, inputs, warnings, results
