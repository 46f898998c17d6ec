// SPDX-License-Identifier: MIT
// Budgets of a command: the planner's request from the flags, and what is reported of its answer.
#pragma once

#include "pipeline/command/command.h"
#include "pipeline/library/renderer.h"
#include "pipeline/planner/forecast.h"
#include "pipeline/planner/planner.h"

#include <string>

namespace plumb {

inline bool hasBudget(const Options& options) { return !options.error.empty() || options.timeMs; }

// Request of the planner for a picture that `base` asks for. Refuses a limit below what rounding costs.
PlannerRequest plannerRequestOf(const Options& options, const RenderRequest& base);

// Takes the unit costs of what draws, measured now or before. Nothing for a request without a renderer.
void takeCosts(PlannerRequest& request, Renderer& renderer, const Options& options);

// Says first how long a traced picture will take, where that is more than a minute. Nothing is measured for it.
void tellLongPicture(const Options& options, const Scene& scene, const RenderRequest& request, Renderer& renderer);
Json forecastJson(const RayForecast& forecast);

// One sentence about the picture that a budget chose.
std::string budgetLine(const PlannerRequest& request, const CheckedPicture& picture);
std::string timeLine(const PlannerRequest& request, const PlannedPicture& plan, double tookMs);

// Keys of docs/outputs.md, "budget". `picture` null: nothing was drawn. `tookMs` below 0: nothing was drawn.
Json budgetJson(const PlannerRequest& request, const PlannedPicture& plan, const CheckedPicture* picture, double tookMs);

Json figuresJson(const BudgetFigures& figures);

// Table of the choices for people: the chosen one, and with `all` every other.
std::string choicesText(const PlannerRequest& request, const PlannedPicture& plan, bool all);

// "about 1.4e9 rays: 3.1e5 from the eye, ..."; empty for a picture without rays.
std::string raysText(const PlannedPicture& plan);

}  // namespace plumb
