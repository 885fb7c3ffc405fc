# Knee angle of a trial, and how long each rise took: Rscript read_tables.R FOLDER, a folder of `lake track`.
folder <- commandArgs(trailingOnly = TRUE)[1]
knee <- read.csv(file.path(folder, "kinematics.csv"))      # an empty cell is NA
events <- read.csv(file.path(folder, "events.csv"))

rises <- merge(subset(events, event == "onset"), subset(events, event == "standing"), by = "repetition", suffixes = c("_onset", "_standing"))
rises$rise_s <- rises$time_s_standing - rises$time_s_onset
print(rises[, c("repetition", "rise_s")])
cat(sprintf("knee angle from %.1f to %.1f degrees\n", min(knee$knee_deg, na.rm = TRUE), max(knee$knee_deg, na.rm = TRUE)))

# Mean angle over the rise: one row per percent.
rise <- subset(knee, !is.na(percent))
mean_rise <- aggregate(knee_deg ~ round(percent), data = rise, FUN = mean)
names(mean_rise) <- c("percent", "knee_deg")
if (interactive()) plot(mean_rise, type = "l", xlab = "rise, %", ylab = "knee angle, degrees")
