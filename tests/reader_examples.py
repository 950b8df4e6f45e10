"""One small file of every format, and what is in it: for the conformance kit, for fuzzing, for the matrix of claims.

To add a format, add an entry to ``EXAMPLES`` under the name of its reader.
"""

import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from built_files import archived, mat, ods, tdms, xls, xlsx

from tribopipe.readers.conformance import Example

GENERIC = {"delimited", "points"}
"""Readers of last resort: they may claim files of other formats, but not with confidence."""

SHEET = [["Run 5", None], ["Time [s]", "Ft"], [None, "mN"], [0.0, 1.5], [0.1, -2.5], [0.2, 12345678.9]]
SHEET_HOLDS = {"rows": 3, "columns": {"Time [s]": "s", "Ft": "mN"}, "encoding": None}
WAVE = {"wf_increment": 0.5, "wf_start_offset": 0.0, "wf_start_time": np.datetime64("2022-05-12T12:21:58")}
FORCES = {"Fz": (np.array([5.25, 5.5, 5.75]), WAVE | {"unit_string": "N"}), "Ft": (np.array([1, 2, 3]), WAVE)}

VECTORS = {
    "time_s": np.array([0.0, 0.5, 1.0]),
    "Ft_mN": np.array([1.5, -2.5, 3.5]),
    "wear_um": np.array([0.25, 0.5, 0.75]),
}


@cache
def _archived() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        return archived(Path(folder))


EXAMPLES: dict[str, list[Example]] = {
    "ducom-winducom": [
        Example(
            "run.dwf",
            b"          TIME;          FF;        WEAR;\r"
            b"        0,9150;        4,80;       -1,25;;\r"
            b"        1,8240;       16,13;        0,50;;\r"
            b"      418,3920;       17,04;        2,75;;\r",
            rows=3,
            columns={"TIME": "s", "FF": "N", "WEAR": "um"},
            signals={"TIME": "time", "FF": "friction_force", "WEAR": "depth"},
            values={"FF": [4.8, 16.13, 17.04]},
            permuted=b"          TIME;        WEAR;          FF;\r"
            b"        0,9150;       -1,25;        4,80;;\r"
            b"        1,8240;        0,50;       16,13;;\r"
            b"      418,3920;        2,75;       17,04;;\r",
        )
    ],
    "bruker-umt": [
        Example(
            "test.txt",
            b"Created by CETR Data Viewer ver.2.19.106 05/12/22 14:43:46\r\n"
            b"Created by CETR UMT ver.1.136.257 12 May 2022 12:21:50\r\nTotal number of steps = 2\r\n\r\n"
            b"Step No. 1\r\n\r\nRadius       = 3.9493\r\nSet Force    = -200\r\nData Count   = 2\r\n"
            b"Started at: 12:21:58.029 12 May 2022\r\n\r\nFx,Fz,Z,T,Ff,COF\r\ng,g,mm,sec,g,\r\n\r\n"
            b"7.683862,-198.963455,-0.6908,0.0000,7.683862,0.038619\r\n"
            b"-7.683862,-199.963455,-0.6909,0.0100,7.683862,0.038426\r\n\r\n"
            b"Step No. 2\r\n\r\nRadius       = 3.9493\r\nSet Force    = -200\r\nData Count   = 2\r\n"
            b"Started at: 12:22:58.029 12 May 2022\r\n\r\nFx,Fz,Z,T,Ff,COF\r\ng,g,mm,sec,g,\r\n\r\n"
            b"8.683862,-198.963455,-0.6918,0.0000,8.683862,0.043646\r\n"
            b"-8.683862,-199.963455,-0.6919,0.0100,8.683862,0.043427\r\n",
            rows=4,
            columns={"Fx": "gf", "Fz": "gf", "Z": "mm", "T": "sec", "Ff": "gf", "COF": None, "segment": "1"},
            signals={"Fz": "normal_force", "Ff": "friction_force", "T": "time", "Z": "depth"},
            values={"segment": [1, 1, 2, 2], "T": [0, 0.01, 0, 0.01]},
        )
    ],
    "rtec-mft": [
        Example(
            "log.csv",
            b"RecipeName,Operator\rStribeck,Ana\r\n"
            b"Step, Timestamp, RecipeStep, DAQ.Fz (N),DAQ.Fx (N),DAQ.COF (),XYZ.Z Depth (mm),\r\n"
            b"1,0.01,1,5.02,1.11,0.221,0.013,\n1,0.02,1,5.03,1.12,0.223,0.014,\n3,0.01,2,5.04,1.13,0.224,0.015,\n"
            b"\nTotalTime\n00:01:08.2500000\n",
            rows=3,
            columns={
                "Step": None,
                "Timestamp": "s",
                "RecipeStep": None,
                "DAQ.Fz (N)": "N",
                "DAQ.Fx (N)": "N",
                "DAQ.COF ()": None,
                "XYZ.Z Depth (mm)": "mm",
            },
            signals={"Timestamp": "time", "DAQ.Fz (N)": "normal_force", "DAQ.Fx (N)": "friction_force"},
            values={"Step": [1, 1, 3], "Timestamp": [0.01, 0.02, 0.01]},
        )
    ],
    "phoenix-compend": [
        Example(
            "test.tsv",
            b"Data file\t\tTEST_2.TSV\r\nTest started at 20:09:56 on 2019-04-09\r\n"
            b"\tTime\tThis Step\tStep Time\tTest Time\tMass\tLoad\tFriction Force"
            b"\tFriction Coefficient\tFriction Force\r\n"
            b"\t1\t1\t3600,\t1\t6100\t59,841\t14,960\t0,25000\t14,91\r\n"
            b"\t2\t1\t3600,\t2\t6100\t59,841\t15,559\t0,26000\t15,49\r\n"
            b"\t3\t2\t3600,\t3\t6100\t59,841\t16,157\t0,27000\t16,07\r\n",
            rows=3,
            columns={
                "Time": "s",
                "This Step": None,
                "Step Time": "s",
                "Test Time": "s",
                "Mass": "g",
                "Load": "N",
                "Friction Force": "N",
                "Friction Coefficient": "1",
                "Friction Force (2)": "N",
            },
            signals={"Time": "time", "Load": "normal_force", "Friction Force": "friction_force"},
            values={"Step Time": [3600, 3600, 3600], "This Step": [1, 1, 2], "Load": [59.841, 59.841, 59.841]},
        )
    ],
    "anton-paar": [
        Example(
            "trb3.txt",
            b"\xef\xbb\xbf"
            + (
                "Time [s]\tDistance [m]\tLaps\tSequence ID\tCycle ID\tMax Linear Speed [m/s]\tNominal Load [N]\tµ\t"
                "Angle [°]\tFriction Force [N]\tTemperature [°C]\tHumidity [%]\tPenetration Depth [µm]\r\n"
                "0.10\t0.010\t0.00\t1\t1\t0.1\t5\t0.1532\t1.5\t0.766\t23.1\t44.0\t0.012\r\n"
                "0.20\t0.020\t0.01\t1\t1\t0.1\t5\t0.1611\t21.0\t0.8055\t23.1\t44.1\t-0.5\r\n"
                "0.30\t0.030\t0.02\t1\t2\t0.1\t5\t0.17\t40.25\t0.85\t23.2\t-1064.6\t1.125\r\n"
            ).encode(),
            rows=3,
            columns={
                "Time [s]": "s",
                "Distance [m]": "m",
                "Laps": "1",
                "Sequence ID": None,
                "Cycle ID": None,
                "Max Linear Speed [m/s]": "m/s",
                "Nominal Load [N]": "N",
                "µ": "1",
                "Angle [°]": "°",
                "Friction Force [N]": "N",
                "Temperature [°C]": "°C",
                "Humidity [%]": "%",
                "Penetration Depth [µm]": "µm",
            },
            signals={"Time [s]": "time", "µ": "friction_coefficient", "Friction Force [N]": "friction_force"},
            values={"Humidity [%]": [44.0, 44.1, -1064.6]},
        )
    ],
    "kyowa-pcd": [
        Example(
            "pcd.csv",
            (
                '"ID番号","PCD-400A"\r\n"タイトル","摩擦試験 No.3"\r\n"試験日時","2019/06/03","14:05:33"\r\n'
                '"測定CH数",2\r\n"デジタル入力","OFF"\r\n"サンプリング周波数(Hz)",100\r\n"集録データ数/CH",3\r\n'
                '"測定時間(sec)",0.03\r\n"CH名称","",""\r\n"CH No","CH1","CH2"\r\n"測定モード","ひずみ","ひずみ"\r\n'
                '"レンジ",10000,10000\r\n"校正係数",0.0125,0.0132\r\n"オフセット",0,0\r\n"ローパス",30\r\n'
                '"単位","g","g"\r\n"Time(sec)","CH1","CH2"\r\n'
                "0.00,1.25,-500.5\r\n0.01,1.375,-501\r\n0.02,-1.5,-499.875\r\n"
            ).encode("shift_jis"),
            rows=3,
            columns={"Time(sec)": "sec", "CH1": "gf", "CH2": "gf"},
            signals={"Time(sec)": "time"},
            values={"CH1": [1.25, 1.375, -1.5]},
            encoding="shift_jis",
        )
    ],
    "t-11": [
        Example(
            "t11.csv",
            b"Time [s];Friction force [N];Displacement [um];Temperature2 [C];Temperature1 [C];Rotational speed [rpm];"
            b"Number of revolutions\r\n"
            b"0,0;1,25;0,0;22,5;23,125;0;0;\r\n0,5;1,5;0,75;22,5;23,25;120;1;\r\n1,0;0;1,5;22,75;23,5;120;2;\r\n",
            rows=3,
            columns={
                "Time [s]": "s",
                "Friction force [N]": "N",
                "Displacement [um]": "um",
                "Temperature2 [C]": "degC",
                "Temperature1 [C]": "degC",
                "Rotational speed [rpm]": "rpm",
                "Number of revolutions": "1",
            },
            signals={"Time [s]": "time", "Friction force [N]": "friction_force", "Displacement [um]": "depth"},
            values={"Displacement [um]": [0, 0.75, 1.5]},
        )
    ],
    "load-cell-frames": [
        Example(
            "cell.csv",
            b"<STX>   0.000KG <CR><LF>\n<STX>   0.072KGM<CR><LF>\n<STX>  -0.458KGM<CR><LF>\n",
            rows=3,
            columns={"load": "kgf", "motion": "1"},
            values={"load": [0, 0.072, -0.458]},
        )
    ],
    "newport-rheofriction": [
        Example(
            "0-1rps2-5N.txt",
            b"0.050\t0.001\t0.700\t10.000\t2.500\t0.400\t0.000\t1.000\t60.000\t500.000\t10.000\t5000.000\t10.000\t"
            b"10.000\t10.000\t-10.000\r\n"
            b"12.035800;0.048575;-0.130228;-0.000320;499.720000;0.088757;0.050000\r\n"
            b"0.135000;0.148945;-0.133837;0.001561;495.790000;0.889057;0.050000\r\n"
            b"0.234400;0.249178;2.506000;0.001545;-491.740000;1.000837;0.050000\r\n",
            rows=3,
            columns={
                "step time": "s",
                "time": "s",
                "normal force": "N",
                "torque": "N*m",
                "stage height": "um",
                "rotational speed": "rps",
                "adjustment speed": "mm/s",
            },
            signals={"normal force": "normal_force"},
            values={"normal force": [-0.130228, -0.133837, 2.506]},
        )
    ],
    "pcs-instruments": [
        Example(
            "ehd.txt",
            (
                b"EHD261 Test Data File\r\nProfile description:\tNew EHD profile\r\nDisc track radius:\t36.273\r\n"
                b"Lubricant name:\r\nNumber of steps completed:\t2\r\nTest started at 28/02/2017 15:47\r\n\r\n"
                b'Step 1 "New spacer zero step" started at 28/02/2017 15:48\r\n'
                b"Step type\tFILM_ZERO\tStep description\tNew spacer zero step\r\n       Ball load = 19.9 N\r\n\r\n"
                b'Step 2 "New film step" started at 28/02/2017 16:09\r\n'
                b"Step type\tFILM\tStep description\tNew film step\r\n"
                b"Rolling Speed (mm/s)\tAverage Film (nm)\t\tStep Time (s)\tTraction Coeff (-)\t\r\n"
                b"20.2\t24.4\t\t10\t0.051\t\r\n30.3\t35.5\t\t20\t0.052\t\r\n40.4\t46.6\t\t30\t0.053\t\r\n\r\n"
                b"All steps completed, test completed normally at 28/02/2017 16:35\r\n"
            ),
            rows=3,
            columns={
                "Rolling Speed (mm/s)": "mm/s",
                "Average Film (nm)": "nm",
                "Step Time (s)": "s",
                "Traction Coeff (-)": "-",
                "segment": "1",
            },
            values={"Average Film (nm)": [24.4, 35.5, 46.6]},
        )
    ],
    "labview-lvm": [
        Example(
            "test.lvm",
            (
                "LabVIEW Measurement\t\r\nWriter_Version\t2\r\nReader_Version\t2\r\nSeparator\tTab\r\n"
                "Decimal_Separator\t.\r\nMulti_Headings\tYes\r\nX_Columns\tOne\r\nTime_Pref\tRelative\r\n"
                "Date\t2017/09/20\r\nTime\t15:44:30.6729\r\n***End_of_Header***\t\r\n\t\r\n"
                + (
                    "Channels\t2\t\t\r\nSamples\t2\t2\t\r\nDate\t2017/09/25\t2017/09/25\t\r\n"
                    "Time\t13:45:59.2289\t13:45:59.2289\t\r\nY_Unit_Label\tN\tmicrometer\t\r\n"
                    "X_Dimension\tTime\tTime\t\r\nX0\t0.0E+0\t0.0E+0\t\r\nDelta_X\t0.5\t0.5\t\r\n"
                    "***End_of_Header***\t\t\t\r\nX_Value\tfz_N\tdx_um\tComment\r\n"
                    "0.000000\t13.157429\t164.995293\r\n0.500000\t13.257429\t165.995293\r\n\r\n"
                )
                * 2
            ).encode(),
            rows=4,
            columns={"X_Value": "s", "fz_N": "N", "dx_um": "micrometer", "segment": "1"},
            signals={"X_Value": "time"},
            values={"segment": [1, 1, 2, 2], "X_Value": [0, 0.5, 0, 0.5]},
        )
    ],
    "ni-tdms": [
        Example(
            "run.tdms",
            tdms({"Test": FORCES}, author="N. N."),
            rows=3,
            columns={"Time": "s", "Fz": "N", "Ft": None},
            signals={"Time": "time"},
            values={"Time": [0, 0.5, 1], "Fz": [5.25, 5.5, 5.75]},
            facts={"operator": "N. N.", "started": "2022-05-12T12:21:58+00:00"},
            encoding=None,
            permuted=tdms({"Test": dict(reversed(FORCES.items()))}, author="N. N."),
        )
    ],
    "matlab": [
        Example(
            "run.mat",
            mat(VECTORS | {"load_N": 5.0, "operator": "N. N."}),
            rows=3,
            columns={"time_s": "s", "Ft_mN": "mN", "wear_um": "um"},
            values={"Ft_mN": [1.5, -2.5, 3.5]},
            encoding=None,
            permuted=mat(dict(reversed(VECTORS.items())) | {"load_N": 5.0, "operator": "N. N."}),
        )
    ],
    "workbook": [
        Example("run.xlsx", xlsx({"Data": SHEET}), **SHEET_HOLDS),
        Example("run.ods", ods({"Data": SHEET}), **SHEET_HOLDS, values={"Ft": [1.5, -2.5, 12345678.9]}),
        Example("run.xls", xls({"Data": SHEET}), **SHEET_HOLDS),
    ],
    "tribopipe-hdf5": [
        Example(
            "run.h5",
            _archived(),
            rows=3,
            columns={"time": "s", "depth": "m", "temperature": "K", "Spin": "rpm", "Remark": None},
            signals={"time": "time", "depth": "depth", "temperature": "temperature"},
            values={"depth": [0, 5e-7, 1e-6]},
            facts={"conditions.normal_load": "0.2 N"},
            encoding=None,
        )
    ],
    "dektak": [
        Example(
            "scan.csv",
            (
                "Scan Parameters\r\nScan Type,Standard Scan\r\nStylus,Radius: 2.5 µm\r\nResolution,0.156 um/sample\r\n"
                "\r\nAnalytical Results\r\nFunction,R.Cur Pos,R.Cur Width,M.Cur Pos,M.Cur Width,Result\r\n"
                "Ra,468.0 um,0.0 um,733.0 um,0.0 um,0.00525 um\r\n\r\nScan Data\r\nLateral um,Raw Micrometer,\r\n"
                "0.0,-0.00933,,\r\n0.2,-0.00760,,\r\n0.3,-0.00640,,\r\n0.5,0.01000,,\r\n"
            ).encode("cp1252"),
            rows=4,
            columns={"Lateral um": "um", "Raw Micrometer": "micrometer"},
            encoding="cp1252",
        )
    ],
    "gwyddion-text": [
        Example(
            "map.txt",
            "# Kanal: Topographie\n# Breite: 3 µm\n# Höhe: 2000 nm\n# Einheiten der Werte: m\n"
            "1.00e-09\t1.50e-09\t3.00e-09\n-2.0e-09\t-3.0e-09\t-6.0e-09\n".encode(),
            rows=6,
            columns={"x": "µm", "y": "nm", "z": "m"},
            values={"z": [1e-9, 1.5e-9, 3e-9, -2e-9, -3e-9, -6e-9], "x": [0.5, 1.5, 2.5] * 2},
        )
    ],
    "points": [
        Example(
            "profile.txt",
            b"".join(b"%.6f\t%.6f\r\n" % (0.001 * number, -13.0 + 0.25 * number) for number in range(12)),
            rows=12,
            columns={"x": None, "z": None},
            values={"z": [-13.0 + 0.25 * number for number in range(12)]},
        )
    ],
    "delimited": [
        Example(
            "signals.csv",
            b"Time [s];Depth [um];Remark;\r\n0,50;1,125;a;\r\n1,00;-2,250;b;\r\n1,50;3,375;c;\r\n",
            rows=3,
            columns={"Time [s]": "s", "Depth [um]": "um", "Remark": None},
            values={"Depth [um]": [1.125, -2.25, 3.375]},
            permuted=b"Depth [um];Remark;Time [s];\r\n1,125;a;0,50;\r\n-2,250;b;1,00;\r\n3,375;c;1,50;\r\n",
        )
    ],
}
