package Sockets;

# What the programs of this folder share: their options, a row of the table, percentiles, seeded choices, many sockets.
use strict;
use warnings;
use Getopt::Long;
use IO::Handle;
use IO::Select;
use POSIX ();
use Socket;
use Time::HiRes qw(sleep time);

# --long, --seed N and --count N: the long form or not, the seed, and how many where that is given.
sub options {
    my ($long, $seed, $count) = (0, 1);
    GetOptions('long' => \$long, 'seed=i' => \$seed, 'count=i' => \$count) or exit 2;
    srand $seed;
    $| = 1;
    return ($long, $seed, $count);
}

# A line of the table: what it is of, what was measured, the figure, what is wanted, whether it holds.
sub row {
    my ($id, $what, $figure, $wanted, $holds) = @_;
    print join("\t", $id, $what, $figure, $wanted, $holds ? 'ok' : 'short'), "\n";
}

# The value below which that share of the values lies.
sub percentile {
    my ($share, @values) = @_;
    @values = sort { $a <=> $b } @values;
    return @values ? $values[int($share * $#values + 0.5)] : 0;
}

# Runs this program again with as many open files as it may have, if they are fewer than wanted; returns how many there are.
sub files {
    my ($wanted) = @_;
    my $now = `prlimit --pid $$ --nofile --output SOFT --noheadings` + 0;
    return $now if $now >= $wanted || $ENV{TORTURE_FILES};
    $ENV{TORTURE_FILES} = 1;
    exec 'bash', '-c', "ulimit -n $wanted 2>/dev/null || ulimit -n \$(ulimit -Hn); exec \"\$@\"", "bash", $^X, $0, @main::ARGV_WAS;
}

# A connection to a daemon, quickly, with so small a buffer for what comes if one is given; undef when it is refused.
sub connect_to {
    my ($daemon, $buffer) = @_;
    socket my $socket, PF_INET, SOCK_STREAM, 0 or die "socket: $!";
    setsockopt $socket, SOL_SOCKET, SO_RCVBUF, $buffer if $buffer;
    return connect($socket, sockaddr_in($daemon->{port}, inet_aton('127.0.0.1'))) ? $socket : undef;
}

# Sends a request that closes its connection; seconds until its answer is whole, the status (0 for none) and the answer.
sub timed {
    my ($daemon, $bytes, $most) = @_;
    my $began = time;
    my $socket = connect_to($daemon) // return (time - $began, 0, '');
    local $SIG{PIPE} = 'IGNORE';
    my $all = '';
    syswrite $socket, $bytes or return (time - $began, 0, '');
    while ((my $left = $began + $most - time) > 0) {
        next unless IO::Select->new($socket)->can_read($left);
        last unless sysread $socket, $all, 65536, length $all;
    }
    return (time - $began, $all =~ m{\AHTTP/1\.1 (\d+)} ? $1 : 0, $all);
}

# What a function returns when it runs with so many open files allowed at most; ours are as before afterwards.
sub limited {
    my ($most, $do) = @_;
    my $before = `prlimit --pid $$ --nofile --output SOFT --noheadings` + 0;
    system('prlimit', '--pid', $$, "--nofile=$most:") == 0 or die "prlimit: $?";
    my $answer = $do->();
    system('prlimit', '--pid', $$, "--nofile=$before:") == 0 or die "prlimit: $?";
    return $answer;
}

# Runs a function in a process of its own, which prints lines; take_lines waits for its end and returns them.
sub beside {
    my ($do) = @_;
    pipe my $in, my $out or die "pipe: $!";
    my $pid = fork // die "fork: $!";
    if (!$pid) {
        close $in;
        $out->autoflush(1);
        eval { $do->($out); 1 } or print STDERR "$@";
        close $out;
        POSIX::_exit(0);
    }
    close $out;
    return { pid => $pid, in => $in };
}
sub take_lines {
    my ($process) = @_;
    my $in = $process->{in};
    my @lines = <$in>;
    waitpid $process->{pid}, 0;
    chomp @lines;
    return @lines;
}

# What a process has open, and what it takes of memory in bytes.
sub opened { my $dir = "/proc/$_[0]{pid}/fd"; return map { /^\d+$/ ? $_ . ' ' . (readlink("$dir/$_") // 'gone') : () } map { s/.*\///r } glob "$dir/*" }
sub descriptors { return scalar(() = glob "/proc/$_[0]{pid}/fd/*") }
sub resident { return Vt::slurp("/proc/$_[0]{pid}/smaps_rollup") =~ /^Rss:\s+(\d+)/m ? 1024 * $1 : 0 }
sub cpu_seconds { my @field = split ' ', Vt::slurp("/proc/$_[0]{pid}/stat") =~ s/^.*\) //sr; return ($field[11] + $field[12]) / POSIX::sysconf(POSIX::_SC_CLK_TCK()) }

# A job whose result has 7 MB, more than a connection's buffers take in.
sub large_result {
    my ($daemon) = @_;
    my ($times, $one) = (30, Vt::sphere_ply(20000));
    my ($head, $points) = $one =~ /\A(.*?end_header\n)(.*)\z/s;
    $head =~ s/vertex (\d+)/'vertex ' . $1 * $times/e;
    my $answer = $daemon->post('/v1/convert?format=ply', $head . $points x $times, Prefer => 'respond-async');
    my $id = Vt::json($answer)->{jobID} // die "no job: $answer->{content}";
    $daemon->finish($id);
    return $id;
}

# Another network beside ours, whose machine may fall silent: both ends' addresses, and a process that waits there. undef where
# that is not allowed (it takes root and a kernel with veth).
sub network {
    my ($ours, $theirs, $name) = ('198.18.77.1', '198.18.77.2', "vt$$");
    return undef if $>;
    my $holder = fork // die "fork: $!";
    if (!$holder) { exec 'unshare', '-n', 'sleep', '600' or POSIX::_exit(127) }
    my $self = bless { holder => $holder, ours => $ours, theirs => $theirs, name => $name }, 'Sockets::Network';
    for (1 .. 200) {
        last if (readlink("/proc/$holder/ns/net") // '') ne (readlink('/proc/self/ns/net') // '');
        sleep 0.02;
    }
    for my $command ("ip link add $name type veth peer name there netns $holder", "ip addr add $ours/30 dev $name", "ip link set $name up",
        "nsenter -t $holder -n ip addr add $theirs/30 dev there", "nsenter -t $holder -n ip link set there up") {
        return undef if system("$command >/dev/null 2>&1") != 0;
    }
    return $self;
}

sub load { open my $file, '<', '/proc/loadavg' or return '?'; return (split ' ', <$file>)[0] }

package Sockets::Network;

# Runs a function there, in a process of its own (as Sockets::beside).
sub inside {
    my ($self, $do) = @_;
    my $path = "/proc/$self->{holder}/ns/net";
    return Sockets::beside(sub {
        open my $there, '<', $path or die "$path: $!";
        my %setns = (x86_64 => 308, aarch64 => 268);
        syscall($setns{ (POSIX::uname())[4] } // die('no setns'), fileno $there, 0) == 0 or die "setns: $!";
        $do->(@_);
    });
}

# From now on nothing leaves that machine.
sub silence { system("nsenter -t $_[0]{holder} -n ip route add blackhole $_[0]{ours}/32 >/dev/null 2>&1") == 0 or die 'no silence' }

sub DESTROY {
    my ($self) = @_;
    return if !$self->{holder};
    kill 'KILL', $self->{holder};
    waitpid $self->{holder}, 0;
    system("ip link del $self->{name} >/dev/null 2>&1");
}

1;
