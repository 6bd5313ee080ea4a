from recordings.checked import CheckedRecording as CheckedRecording
from recordings.checked import check as check
from recordings.finding import Finding as Finding
from recordings.formats.imu_array import ImuArray as ImuArray
from recordings.formats.imu_array import read_imu_array as read_imu_array
from recordings.formats.model_tables import (
    recording_from_model_table as recording_from_model_table,
)
from recordings.formats.model_tables import recording_to_model_table as recording_to_model_table
from recordings.formats.tables import recording_from_table as recording_from_table
from recordings.formats.tables import recording_to_table as recording_to_table
from recordings.formats.tables import write_table as write_table
from recordings.ink import Ink as Ink
from recordings.ink import InkMatch as InkMatch
from recordings.ink import ink_match as ink_match
from recordings.motion_list import motion_names as motion_names
from recordings.read import read_recording as read_recording
from recordings.read import read_written as read_written
from recordings.simulate_pen import sensors_with_a_rate as sensors_with_a_rate
from recordings.simulate_pen import simulate as simulate
from recordings.simulate_pen import simulate_model as simulate_model
from recordings.simulate_turntable import simulate_stroke as simulate_stroke
from recordings.simulate_turntable import simulate_table as simulate_table
from recordings.thinning import CameraThinning as CameraThinning
from recordings.thinning import LeftOutError as LeftOutError
from recordings.thinning import left_out_error as left_out_error
from recordings.thinning import thinned as thinned
from recordings.written import WrittenRecording as WrittenRecording
