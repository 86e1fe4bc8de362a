//! What performance counters counted, as reports tell it.

use serde::Serialize;

use super::Figure;

/// What a device's performance counters (VK_KHR_performance_query) counted in one frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CounterFigures {
    /// How often the frame was drawn, since the device cannot count all at once.
    pub passes: u32,
    /// In the order in which they were asked for.
    pub counters: Vec<CounterFigure>,
}

/// One counter of [`CounterFigures`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CounterFigure {
    /// Name, in the driver's words.
    pub name: String,
    /// Category, in the driver's words.
    pub category: String,
    /// `VkPerformanceCounterUnitKHR` in lower case: "generic" of plain numbers.
    pub unit: String,
    /// What was counted; `null` where the driver had no result, although the frame had finished.
    pub value: Option<Figure>,
}
