//! Error against seconds: renders of one scene in several configurations, measured in turns.

mod contest;
mod external;
mod reference;
mod report;
mod shot;

pub use contest::{Contender, Contest, How, Row};
pub use external::SeriesFile;
pub use reference::{Cache, Mean, Reference};
pub use report::{Clock, Report};
pub use shot::Setting;
