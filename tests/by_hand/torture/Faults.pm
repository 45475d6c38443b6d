# What the rows of disks and faults share besides Sockets.pm: a line a figure, a small disk of the row's own, calls that fail.
package Faults;
use strict;
use warnings;
use Exporter 'import';
use File::Temp qw(tempdir);
use IO::Socket::INET ();
use POSIX ();
use Sockets ();
use Vt ();

my @mounted;
my $owner = $$;
END {
    local $?;
    if ($$ == $owner) { system('umount', '-l', $_) == 0 and rmdir $_ for @mounted }
}

our @EXPORT = qw(options figure small_disk fill inject free_port);

# --long and --seed N of a row's command line.
sub options {
    my ($long, $seed, $count) = Sockets::options();
    return (long => $long, seed => $seed, count => $count);
}

# One line of the table; ok when the figure is what was wanted, unless that is said.
sub figure {
    my ($id, $what, $figure, $wanted, $ok) = @_;
    $ok = $figure eq $wanted if @_ < 5;
    Sockets::row($id, $what, $figure, $wanted, $ok);
}

# A disk of its own of so many kilobytes, gone with the process: starts this program again in a mount namespace first.
# undef where that is not allowed.
sub small_disk {
    my ($kilobytes) = @_;
    if (!$ENV{TORTURE_NAMESPACE}) {
        local $ENV{TORTURE_NAMESPACE} = 1;
        return undef if system('unshare -m true 2>/dev/null') != 0;
        exec 'unshare', '-m', $^X, $0, @main::arguments or die "unshare: $!";
    }
    my $dir = tempdir;
    push @mounted, $dir;
    return system("mount -t tmpfs -o size=${kilobytes}k disk $dir") == 0 ? $dir : undef;
}

# Takes what is left of the disk, but for so many bytes.
sub fill {
    my ($dir, $but) = @_;
    open my $out, '>>:raw', "$dir/filler" or die "filler: $!";
    my $block = "\0" x 4096;
    1 while defined syswrite $out, $block;
    truncate $out, (-s $out) - ($but // 0) if $but;
    close $out;
}

# From now on these system calls of a daemon do that ("fdatasync:error=EIO"), until it ends; strace's process, or undef
# where there is none.
sub inject {
    my ($daemon, $fault) = @_;
    my $log = File::Temp->new;
    my ($calls) = split /:/, $fault;
    my $pid = fork // die "fork: $!";

    if (!$pid) {
        open STDERR, '>', "$log";
        exec 'strace', '-f', '-qq', '-o', '/dev/null', '-e', "trace=$calls", '-e', "inject=$fault", '-p', $daemon->{pid}
            or POSIX::_exit(127);
    }
    for (1 .. 200) {
        return $pid if Vt::slurp("/proc/$daemon->{pid}/status") =~ /^TracerPid:\s+$pid$/m;
        return undef if waitpid($pid, POSIX::WNOHANG()) > 0;
        select undef, undef, undef, 0.02;
    }
    return undef;
}

# A port that nobody has just now, for a daemon that is to come back where it was: below those that the kernel gives to
# connections, one of which would have it meanwhile.
sub free_port {
    for (1 .. 100) {
        my $port = 20_000 + int rand 12_000;
        return $port if IO::Socket::INET->new(LocalAddr => '127.0.0.1', LocalPort => $port, Listen => 1);
    }
    die "port: $!";
}

1;
