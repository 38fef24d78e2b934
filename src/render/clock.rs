//! How long the device works on a frame.

use std::time::Duration;

use ash::vk;

use super::{
    error::{RenderError, Trying as _},
    gpu::Gpu,
};

/// Queries of the time before a frame's commands, and after them.
///
/// The one behind each is not asked for: Mesa 25's lavapipe writes a time for each view of the last pass, also behind that pass, and for two views one more than there is.
const FIRST: u32 = 0;
const LAST: u32 = 2;
const QUERIES: u32 = 4;

/// Two times of the device, before and after a frame's commands.
pub(crate) struct Clock {
    pool: vk::QueryPool,
    /// A frame was timed since the last look.
    runs: bool,
    gpu: Gpu,
}

impl Clock {
    /// None where the device does not tell the time.
    pub(crate) fn new(gpu: &Gpu) -> Result<Option<Self>, RenderError> {
        if gpu.tick_bits == 0 || gpu.limits.timestamp_period <= 0.0 {
            return Ok(None);
        }
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(QUERIES);
        // SAFETY: a plain pool.
        let pool = unsafe { gpu.device.create_query_pool(&info, None) }.trying("making a clock")?;
        Ok(Some(Self {
            pool,
            runs: false,
            gpu: gpu.clone(),
        }))
    }

    /// How long the last timed frame took, once; to be asked when it is done.
    pub(crate) fn read(&mut self) -> Option<Duration> {
        if !std::mem::take(&mut self.runs) {
            return None;
        }
        let ticks = [self.ticks(FIRST)?, self.ticks(LAST)?];
        let (bits, tick_ns) = (self.gpu.tick_bits, self.gpu.limits.timestamp_period);
        Some(between(ticks, bits, tick_ns))
    }

    fn ticks(&self, query: u32) -> Option<u64> {
        let (device, flags) = (&self.gpu.device, vk::QueryResultFlags::TYPE_64);
        let mut ticks = [0_u64];
        // SAFETY: the query was written by commands that are done.
        let found = unsafe { device.get_query_pool_results(self.pool, query, &mut ticks, flags) };
        found.ok().map(|()| ticks[0])
    }

    /// First of a frame's commands.
    pub(crate) fn start(&self, commands: vk::CommandBuffer) {
        // When all before it is done: another frame may be under way.
        let first = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the command buffer is recording outside of a pass, and the pool's last use is done.
        unsafe {
            let device = &self.gpu.device;
            device.cmd_reset_query_pool(commands, self.pool, 0, QUERIES);
            device.cmd_write_timestamp(commands, first, self.pool, FIRST);
        }
    }

    /// Last of them.
    pub(crate) fn stop(&self, commands: vk::CommandBuffer) {
        let last = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: as above.
        unsafe {
            self.gpu
                .device
                .cmd_write_timestamp(commands, last, self.pool, LAST);
        }
    }

    /// The frame was handed over.
    pub(crate) fn runs(&mut self) {
        self.runs = true;
    }
}

impl Drop for Clock {
    fn drop(&mut self) {
        // SAFETY: the slot's commands are done before its clock goes.
        unsafe { self.gpu.device.destroy_query_pool(self.pool, None) };
    }
}

/// Between two readings of so many bits, which may have begun anew; `tick_ns`: how long a tick is.
fn between([first, last]: [u64; 2], bits: u32, tick_ns: f32) -> Duration {
    let mask = if bits >= 64 {
        u64::MAX
    } else {
        (1 << bits) - 1
    };
    let ticks = last.wrapping_sub(first) & mask;
    #[allow(clippy::cast_precision_loss, reason = "a frame has few ticks")]
    let seconds = ticks as f64 * f64::from(tick_ns) * 1e-9;
    // Longer than a minute is no frame.
    Duration::from_secs_f64(seconds.clamp(0.0, 60.0))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn ticks_are_counted_across_the_end() {
        for (ticks, bits, tick_ns, nanos) in [
            ([100, 1_100], 64, 1.0, 1_000),
            ([100, 1_100], 36, 52.08, 52_080),
            ([0xffff_fff0, 0x10], 32, 1.0, 32),
            ([u64::MAX, 9], 64, 10.0, 100),
            ([0, u64::MAX], 64, 1.0, 60_000_000_000),
        ] {
            let took = between(ticks, bits, tick_ns).as_nanos();
            assert!(took.abs_diff(nanos) <= nanos / 10_000, "{ticks:?}: {took}");
        }
    }
}
